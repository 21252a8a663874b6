"""An exchange folder from shots that were fired here."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import tifffile

from analysis.campaign import DESCRIPTION, FRAMES, POSES, SHOT_LIST
from analysis.exchange.description import description
from analysis.exchange.folder import write_shot_list
from analysis.exchange.pose_table import PoseRow, write_pose_rows
from analysis.exchange.shot_list import EXCLUDED, NOTE, TAGS, ShotRow, exposure_column
from analysis.setup import CameraSetup, Setup, SlowErrors, without_exposure
from analysis.slow_errors import typical
from rigctl.cameras.frames import FrameSequence
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.exchange.amending import tags_field
from rigctl.exchange.importing import CONFIGURATION, SIMULATED
from rigctl.measuring.stored_poses import poses_of, slow_errors_of
from rigctl.measuring.stored_shot import exposed_setup
from rigctl.progress import Progress
from rigctl.store import ShotRecord
from rigctl.store.folders import ShotFolders

NAME = "name"
"""Column in which a shot keeps the name it had in the catalogue it was fired into."""


@dataclass(frozen=True, slots=True)
class Measured:
    """Poses of one shot, with their slow errors."""

    poses: Mapping[str, Sequence[PoseRow]]
    slow: SlowErrors


def write_fired(
    folder: Path,
    campaign: str,
    shots: Sequence[ShotRecord],
    folders: ShotFolders,
    progress: Progress,
) -> None:
    """Write campaign.toml, shots.csv, frames and, where there are any, poses.csv.

    Parameters
    ----------
    shots
        Those with frames, in the order of firing.

    Raises
    ------
    AnalysisInputError
        They differ in camera, spheres or surroundings: one description cannot be of all.
    StoreError, NotFoundError
        Frames or results on disk are not those that were stored.
    OSError
        The folder cannot be written.
    """
    (folder / FRAMES).mkdir()
    setups: dict[str, Setup] = {}
    measured: dict[int, Measured] = {}
    for done, shot in enumerate(shots):
        progress(f"writing shot {shot.id}", done / len(shots))
        setups[shot.id] = exposed_setup(folders.manifest(shot.id))
        _write_frames(folder / FRAMES / f"{shot.number:04d}.tiff", folders.frames(shot.id))
        if (found := _measured(shot, folders)) is not None:
            measured[shot.number] = found
    require_one_setup(campaign, setups)
    setup = typical(setups[shots[0].id], [each.slow for each in measured.values()])
    (folder / DESCRIPTION).write_text(description(campaign, setup), encoding="utf-8")
    write_shot_list(folder / SHOT_LIST, [_row(shot, setups[shot.id].camera) for shot in shots])
    if measured:
        poses = ((number, each.poses) for number, each in measured.items())
        write_pose_rows(folder / POSES, poses)


def _write_frames(path: Path, frames: FrameSequence) -> None:
    tifffile.imwrite(path, frames.pixels, photometric="minisblack")
    times = {"times_s": (frames.times_s - frames.times_s[:1]).tolist()}
    path.with_suffix(".json").write_text(json.dumps(times), encoding="utf-8")


def _measured(shot: ShotRecord, folders: ShotFolders) -> Measured | None:
    if shot.results == 0:
        return None
    result: Json = folders.result(shot.id, shot.results)
    if "poses" not in result:
        return None
    errors: Json | None = result.get("slow_errors")
    slow = slow_errors_of(errors) if errors else SlowErrors(one_body_frame=False)
    return Measured(poses_of(result["poses"], slow), slow)


def _row(shot: ShotRecord, camera: CameraSetup) -> ShotRow:
    settings = shot.ordered.model_dump(mode="json")
    numbers = {name: float(value) for name, value in settings.items() if value is not None}
    words = {
        NAME: shot.id,
        SIMULATED: "yes" if shot.simulated else "no",
        CONFIGURATION: shot.configuration,
        EXCLUDED: shot.excluded or "",
        NOTE: shot.note or "",
        TAGS: tags_field(shot.tags),
    }
    return ShotRow(
        shot.number,
        shot.fired_at,
        numbers | exposure_column(camera),
        {name: word for name, word in words.items() if word},
    )


def require_one_setup(name: str, setups: Mapping[str, Setup]) -> None:
    """Require the shots of a campaign, by their names, to have been fired under one set-up.

    The exposure may change from shot to shot.

    Raises
    ------
    AnalysisInputError
        Two of them differ: one model of camera and spheres would be wrong for one of them.
    """
    (first, common), *others = ((shot, without_exposure(each)) for shot, each in setups.items())
    if other := next((shot for shot, setup in others if setup != common), None):
        raise AnalysisInputError(
            f"shots {first} and {other} differ in camera, spheres or surroundings",
            part=f"campaign {name}",
            todo="fire each set-up under a campaign of its own",
        )
