"""An exchange folder becomes a campaign of the catalogue, whole or not at all.

Beside each imported shot lie its manifest, and the first result where it has poses.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from analysis.exchange.shot_list import ShotRow
from rigctl.documents import Json
from rigctl.plain_text import require_word
from rigctl.progress import Progress
from rigctl.store import Store
from rigctl.store.durable import sync_folder, write_synced
from rigctl.store.folders import sha256
from rigctl.store.imports import LISTING, Stage
from rigctl.store.integrity.copying import copy_synced
from rigctl.store.states import ShotState

if TYPE_CHECKING:
    from rigctl.exchange.contents import Contents, Frames
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from typing import TYPE_CHECKING

from pydantic import ValidationError

from analysis.exchange.pose_table import own_slow_errors
from analysis.exchange.shot_list import EXCLUDED, EXPOSURE, NOTE, TAGS
from analysis.setup import setup_document
from rigctl.exchange.amending import tags_in
from rigctl.measuring.stored_poses import poses_document, slow_errors_document
from rigctl.settings import ShotSettings
from rigctl.store.imports import ImportedShot

if TYPE_CHECKING:
    from rigctl.exchange.contents import Contents


OTHERS, FRAMES = "folder", "frames"


@dataclass(frozen=True, slots=True)
class Imported:
    """A campaign that was imported: its name, its shots, and how many of them stand where."""

    campaign: str
    shots: int
    measured: int
    to_analyse: int


def import_campaign(
    store: Store, contents: Contents, actor: str, *, name: str | None = None, progress: Progress
) -> Imported:
    """Import an exchange folder that was read, under its own name or under another.

    Every file is kept as it is, frames beside their shots, with its digest. Measured poses count
    as the first result of their shots; shots with frames alone wait for their analysis.

    Parameters
    ----------
    progress
        Called at each step.

    Raises
    ------
    SettingsError
        The name could not be a folder's.
    RefusedError
        There is a campaign of this name.
    StoreError
        The disk or the catalogue refuses; nothing is imported.
    """
    campaign = require_word(
        name or contents.title,
        "cannot be the name of a campaign in the catalogue",
        "name",
        todo="give it another with --name; the folder keeps its own",
    )
    with store.imports.staged(campaign) as stage:
        listing: dict[str, Json] = {}
        for done, row in enumerate(contents.rows):
            progress(f"keeping shot {row.shot}", done / len(contents.rows))
            _keep_shot(stage, row, contents, campaign, listing)
        _keep_others(stage, contents, listing)
        about = {"format": FORMAT, "campaign": campaign, "title": contents.title, "files": listing}
        _write(stage.path / LISTING, about)
        _sync(stage.path)
        found = [imported_shot(row, contents) for row in contents.rows]
        store.imports.publish(stage, campaign, found, actor, contents.remarks)
    states = [shot.state for shot in found]
    return Imported(
        campaign,
        shots=len(found),
        measured=states.count(ShotState.ANALYSED),
        to_analyse=states.count(ShotState.STORED),
    )


def _keep_shot(
    stage: Stage, row: ShotRow, contents: Contents, campaign: str, listing: dict[str, Json]
) -> None:
    shot = stage.shot(row.shot)
    home = stage.path / shot
    home.mkdir()
    frames = contents.frames.get(row.shot)
    about = {} if frames is None else _keep_frames(home, frames, contents.folder, listing)
    _write(home / "manifest.json", manifest(shot, row, contents, campaign, about))
    if row.shot in contents.poses or row.shot in contents.tabulated:
        _write(home / "result-0001.json", first_result(shot, row, contents))


def _keep_frames(home: Path, frames: Frames, folder: Path, listing: dict[str, Json]) -> Json:
    """Copy the frames of a shot beside its manifest; return their entry in the manifest."""
    for source in frames.files:
        kept = home / FRAMES / source.relative_to(folder / FRAMES)
        listing[source.relative_to(folder).as_posix()] = {
            "kept": f"{home.name}/{kept.relative_to(home).as_posix()}",
            "sha256": copy_synced(source, kept),
        }
    kept = home / FRAMES / frames.path.relative_to(folder / FRAMES)
    return {
        "file": kept.relative_to(home).as_posix(),
        "sha256": sha256(kept),
        "shape": list(frames.shape),
        "dtype": frames.dtype,
        "times_s": list(frames.times_s),
        "sequence": list(range(frames.shape[0])),
        "lost": [],
        "exposure_s": frames.exposure_s,
        "notes": list(frames.notes),
        "source": f"imported from {frames.path.relative_to(folder).as_posix()}",
    }


def _keep_others(stage: Stage, contents: Contents, listing: dict[str, Json]) -> None:
    """Copy what is no shot's frames: tables, and whatever else lies there."""
    files = (path for path in contents.folder.rglob("*") if path.is_file())
    for source in sorted(files):
        name = source.relative_to(contents.folder).as_posix()
        if name not in listing:
            digest = copy_synced(source, stage.path / OTHERS / name)
            listing[name] = {"kept": f"{OTHERS}/{name}", "sha256": digest}


def _write(path: Path, document: Json) -> None:
    text = json.dumps(document, allow_nan=False, indent=1).encode()
    write_synced(path, lambda file: file.write(text))


def _sync(folder: Path) -> None:
    """Force the entries of a folder and of all below it to disk."""
    inner: Iterable[Path] = (path for path in folder.rglob("*") if path.is_dir())
    for path in (*inner, folder):
        sync_folder(path)


FORMAT = 2
"""2: the set-up is one table; manifests of format 1 are read as before."""
METHOD = "imported"
CONFIGURATION, SIMULATED = "configuration", "simulated"
"""Text columns of shots.csv that this program adds to its own shots."""

_SETTINGS = tuple(ShotSettings.model_fields)


def imported_shot(row: ShotRow, contents: Contents) -> ImportedShot:
    """Return a line of shots.csv as a shot of the catalogue."""
    frames = contents.frames.get(row.shot)
    measured = row.shot in contents.poses or row.shot in contents.tabulated
    return shot_of_row(row, None if frames is None else frames.shape[0], measured=measured)


def shot_of_row(row: ShotRow, frames: int | None, *, measured: bool) -> ImportedShot:
    """Return a shot by its line, how many frames it has, and whether it came with a result."""
    failure = None
    if measured:
        state = ShotState.ANALYSED
    elif frames is not None:
        state = ShotState.STORED
    else:
        state, failure = ShotState.REFUSED, "its folder holds nothing of this shot but its line"
    return ImportedShot(
        number=row.shot,
        settings=_settings(row),
        fired_at=_utc(row.time),
        state=state,
        frames=frames,
        failure=failure,
        note=row.words.get(NOTE),
        tags=tags_in(row.words.get(TAGS, "")),
        excluded=row.words.get(EXCLUDED),
        simulated=row.words.get(SIMULATED) == "yes",
        configuration=row.words.get(CONFIGURATION, ""),
    )


def manifest(shot: str, row: ShotRow, contents: Contents, campaign: str, frames: Json) -> Json:
    """Return the manifest of an imported shot, as far as its folder has the values.

    `settings` has every numeric column of shots.csv, whatever it means.
    """
    setup = contents.setup
    return {
        "format": FORMAT,
        "shot": shot,
        "number": row.shot,
        "campaign": campaign,
        "fired_at": None if row.time is None else row.time.isoformat(),
        "settings": row.numbers,
        "words": row.words,
        "imported": {"folder": contents.folder.name, "campaign": contents.title},
        "program": {"name": "rigctl", "version": version("rigctl")},
        "setup": setup_document(setup),
        "exposure_s": _exposure_s(row, frames),
        "frames": frames or None,
    }


def _exposure_s(row: ShotRow, frames: Json) -> float | None:
    """Return what shots.csv states, else what the camera's own file does."""
    stated = row.numbers.get(EXPOSURE)
    own: float | None = frames.get("exposure_s")
    return own if stated is None else stated * 1e-6


def first_result(shot: str, row: ShotRow, contents: Contents) -> Json:
    """Return the result that an imported shot comes with."""
    setup = contents.setup
    poses = contents.poses.get(row.shot)
    return {
        "shot": shot,
        "method": METHOD,
        "status": METHOD,
        "frame_rate_hz": setup.camera.frame_rate_hz,
        **({} if poses is None else {"poses": poses_document(poses)}),
        "slow_errors": slow_errors_document(own_slow_errors(poses or {}, setup.measurement)),
    }


def _settings(row: ShotRow) -> ShotSettings | None:
    """Return the settings that a rig would need; None where they are incomplete."""
    stated: Mapping[str, float] = {n: row.numbers[n] for n in _SETTINGS if n in row.numbers}
    try:
        return ShotSettings.model_validate(stated)
    except ValidationError:
        return None


def _utc(time: datetime | None) -> datetime | None:
    """Return a time in UTC; one without a zone is taken as UTC (exchange-folder.md)."""
    if time is None:
        return None
    return time.replace(tzinfo=UTC) if time.tzinfo is None else time.astimezone(UTC)
