"""Documents beside an imported shot: its manifest, and the first result where it has poses."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from typing import TYPE_CHECKING

from pydantic import ValidationError

from analysis.exchange.pose_table import own_slow_errors
from analysis.exchange.shot_list import EXCLUDED, EXPOSURE, NOTE, TAGS, ShotRow
from analysis.setup import setup_document
from rigctl.documents import Json
from rigctl.exchange.amending import tags_in
from rigctl.measuring.stored_poses import poses_document, slow_errors_document
from rigctl.settings import ShotSettings
from rigctl.store.imports import ImportedShot
from rigctl.store.states import ShotState

if TYPE_CHECKING:
    from rigctl.exchange.contents import Contents


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
