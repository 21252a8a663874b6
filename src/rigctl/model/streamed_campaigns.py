"""From the name of a campaign of any length, or its folder, to the parts that are fitted."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from pathlib import Path

from analysis.model.data.columns import ShotColumns
from analysis.model.data.parts import SHOTS_AT_ONCE
from analysis.model.data.reading import Reading, stream_poses
from analysis.model.data.stream import PoseStream
from analysis.setup import SlowErrors
from analysis.slow_errors import typical
from rigctl.errors import NotFoundError
from rigctl.input_errors import as_analysis_errors
from rigctl.measuring.measured import MeasuredFiles, each_measured
from rigctl.model.campaigns import StoredShot, require_one_setup, stored_shot
from rigctl.opening import read_store
from rigctl.temporary_room import temporary_room


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
        "no shot of this campaign has frames that show both spheres",
        part=f"campaign {name}",
        todo="look at why its shots were refused",
    )
