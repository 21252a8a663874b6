"""From the name of a campaign, or its folder, to the poses that are fitted."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import islice
from pathlib import Path

from analysis.campaign import FRAMES, POSES
from analysis.exchange.pose_table import Spheres
from analysis.exchange.shot_list import EXCLUDED, ShotRow, exposure_column
from analysis.model.data.columns import ShotColumns
from analysis.model.data.gather import every_shot, gather, gather_poses, nothing_seen, usable
from analysis.model.data.parts import SHOTS_AT_ONCE
from analysis.model.data.poses import PoseData
from analysis.model.data.reading import Reading, stream_poses
from analysis.model.data.stream import PoseStream
from analysis.model.data.tables import Data
from analysis.setup import CameraSetup, Setup, SlowErrors
from analysis.slow_errors import typical
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError, NotFoundError
from rigctl.exchange.fired import require_one_setup
from rigctl.input_errors import as_analysis_errors
from rigctl.measuring.measured import MeasuredFiles, each_measured, measured_files
from rigctl.measuring.stored_poses import poses_of, slow_errors_of
from rigctl.measuring.stored_shot import exposed_setup
from rigctl.model.tabulated_campaigns import is_tabulated, tabulated
from rigctl.opening import read_store
from rigctl.store import Store, StoreReader
from rigctl.temporary_room import temporary_room


def open_campaign(
    campaign: Path, configuration: Path | None = None, *, poses: bool = False
) -> tuple[str, Data]:
    """Return title and data of a campaign folder, or of a campaign in the catalogue.

    Parameters
    ----------
    campaign
        A folder, which is used as it is; else a single word is looked up in the store.
    configuration
        File of the rig whose store is meant; None: the simulated rig's.
    poses
        Whether poses are wanted even where the folder holds a later stage.

    Raises
    ------
    AnalysisInputError
        The folder cannot be read, holds no poses where these are wanted, or the shots do not go
        together.
    NotFoundError
        There is neither such a folder nor such a campaign, or none of its shots is measured.
    ConfigurationError, StoreError
        Configuration or store cannot be read.
    """
    if campaign.exists() or len(campaign.parts) != 1:
        with as_analysis_errors():
            return gather_poses(campaign) if poses else gather(campaign)
    name = str(campaign)
    with read_store(configuration) as store:
        if is_tabulated(store, name):
            if poses:
                raise AnalysisInputError(
                    "came with tabulated contacts alone, which hold no poses",
                    part=f"campaign {name}",
                    todo="import a folder that has its poses.csv or its frames",
                )
            with as_analysis_errors():
                return name, tabulated(store, name)
        return campaign_poses(store, name)


def folder_data(folder: Path) -> tuple[str, Data]:
    """Return title and poses of a campaign's folder, or its tables where it has nothing else.

    Frames without poses are measured now.

    Raises
    ------
    AnalysisInputError
        The folder cannot be read, or holds no shot that is measured.
    """
    seen = any((folder / name).exists() for name in (POSES, FRAMES))
    with as_analysis_errors():
        return gather_poses(folder) if seen else gather(folder)


def campaign_poses(store: Store | StoreReader, name: str) -> tuple[str, PoseData]:
    """Return title and poses of a campaign in the catalogue.

    Raises
    ------
    NotFoundError
        There is no such campaign, or none of its shots is measured.
    AnalysisInputError
        As `poses_from`.
    StoreError
        The catalogue cannot be read.
    """
    return name, poses_from(name, measured_files(store, name))


def poses_from(name: str, files: Sequence[MeasuredFiles]) -> PoseData:
    """Put the poses of stored shots into arrays; shots are named by their numbers.

    Raises
    ------
    AnalysisInputError
        A file cannot be read or holds no poses, or two shots were fired under different set-ups:
        one model of camera and spheres would be wrong for one of them.
    """
    shots = [stored_shot(name, own) for own in files]
    setups = {shot.name: shot.setup for shot in shots}
    require_one_setup(name, setups)
    slow = [shot.slow for shot in shots if shot.slow is not None]
    setup = typical(shots[0].setup, slow)
    spheres = {s.row.shot: s.spheres for s in shots}
    data = usable(every_shot(spheres, [s.row for s in shots], setup))
    if len(data.shots) == 0:
        raise AnalysisInputError(nothing_seen(setup), part=f"campaign {name}")
    return data


@dataclass(frozen=True, slots=True)
class StoredShot:
    """A measured shot as its files have it: its name, settings, poses and set-up."""

    name: str
    row: ShotRow
    spheres: Spheres
    setup: Setup
    slow: SlowErrors | None


def stored_shot(campaign: str, files: MeasuredFiles) -> StoredShot:
    """Read a measured shot.

    Raises
    ------
    AnalysisInputError
        A file cannot be read or holds no poses.
    """
    manifest, result = _read(files.manifest), _read(files.result)
    try:
        errors = result.get("slow_errors")
        slow = None if errors is None else slow_errors_of(errors)
        setup = exposed_setup(manifest)
        return StoredShot(
            name=str(manifest["shot"]),
            row=_row(manifest, setup.camera, excluded=files.excluded),
            spheres=poses_of(result["poses"], slow),
            setup=setup,
            slow=slow,
        )
    except (KeyError, TypeError, ValueError) as error:
        raise AnalysisInputError(
            f"holds no poses of this form: {error!r}",
            part=str(files.result),
            todo=f"have campaign {campaign} analysed again",
        ) from error


def _row(manifest: Json, camera: CameraSetup, *, excluded: bool) -> ShotRow:
    """Return a shot's settings as a row of shots.csv: every number is a covariate."""
    number = int(manifest["number"])
    fired_at = manifest["fired_at"]
    numbers = {key: float(v) for key, v in manifest["settings"].items() if v is not None}
    time = None if fired_at is None else datetime.fromisoformat(fired_at)
    numbers |= exposure_column(camera)
    return ShotRow(number, time, numbers, {EXCLUDED: "by a person"} if excluded else {})


def _read(path: Path) -> Json:
    try:
        document: Json = json.loads(path.read_bytes())
    except (OSError, ValueError) as error:
        raise AnalysisInputError(
            f"cannot be read: {error}", part=str(path), todo="restore the folder from a backup"
        ) from error
    return document


def open_stream(campaign: Path, configuration: Path | None = None) -> tuple[str, PoseStream]:
    """Return title and poses of a campaign folder, or of a campaign in the catalogue.

    Parameters
    ----------
    campaign
        A folder with poses.csv, or that file; else a single word is looked up in the store.
    configuration
        File of the rig whose store is meant; None: the simulated rig's.

    Raises
    ------
    AnalysisInputError
        The folder cannot be read or holds no poses.csv, or the shots do not go together.
    NotFoundError
        There is neither such a folder nor such a campaign, or none of its shots is measured.
    ConfigurationError, StoreError
        Configuration or store cannot be read, or the temporary folder is full.
    """
    with temporary_room():
        if campaign.exists() or len(campaign.parts) != 1:
            with as_analysis_errors():
                return stream_poses(campaign)
        with read_store(configuration) as store:
            name = str(campaign)
            return name, stream_from(name, each_measured(store, name))


def stream_from(name: str, files: Iterable[MeasuredFiles]) -> PoseStream:
    """Take up the poses of stored shots, so many at a time; shots are named by their numbers.

    Raises
    ------
    AnalysisInputError
        As `rigctl.model.campaigns.poses_from`.
    NotFoundError
        There are no shots, or none shows both spheres.
    OSError
        The temporary folder is full.
    """
    columns, read, slow = ShotColumns(), Reading(), list[SlowErrors]()
    first: StoredShot | None = None
    shots = (stored_shot(name, own) for own in files)
    while part := list(islice(shots, SHOTS_AT_ONCE)):
        first = first or part[0]
        require_one_setup(name, {shot.name: shot.setup for shot in (first, *part)})
        for shot in part:
            columns.add(shot.row)
        slow += [shot.slow for shot in part if shot.slow is not None]
        read.add({shot.row.shot: shot.spheres for shot in part}, columns, first.setup)
    if first is not None:
        setup = typical(first.setup, slow)
        stream = read.finished(columns, setup)
        if len(stream.shots) > 0:
            return stream
    raise NotFoundError(
        nothing_seen(first.setup) if first is not None else "no shot of this campaign is measured",
        part=f"campaign {name}",
        todo="look at why its shots were refused",
    )
