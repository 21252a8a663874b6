"""Compare a shot's row with its manifest, which never changes after it is written."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rigctl.store.integrity.faults import Fault
from rigctl.store.orders import order_document, outcome_document
from rigctl.store.records import Request, ShotRecord
from rigctl.store.states import ShotState

Json = dict[str, Any]

_EDITED = frozenset({"note", "format"})
"""Fields that may be edited afterwards, or are not part of the shot."""


def verify_row(shot: ShotRecord, request: Request | None, manifest: Json) -> list[Fault]:
    """Compare a row with the manifest of its shot, as far as a manifest of its time goes."""
    part = f"shot {shot.id}"
    try:
        return [
            Fault(part, f"{name} is {row!r} in the catalogue and {stated!r} in the manifest")
            for name, row, stated in _pairs(shot, request, manifest)
            if row != stated
        ]
    except (AttributeError, KeyError, TypeError, IndexError) as error:
        return [Fault(part, f"its manifest cannot be compared with its row: {error!r}")]


def _pairs(
    shot: ShotRecord, request: Request | None, manifest: Json
) -> Iterator[tuple[str, object, object]]:
    """Give each field that both state: its name, the row's word, the manifest's word."""
    frames = manifest.get("frames")
    if frames and shot.outcome is not None:
        yield "frames", shot.frames, frames["shape"][0]
    if shot.imported_as is not None:
        yield "imported_as", shot.imported_as, manifest["number"]
        yield "campaign", shot.campaign, manifest["campaign"]
        return
    yield from _common("", order_document(shot, request), manifest)
    if shot.outcome is None:
        # The manifest comes first, then the row.
        return
    if "fired_at" in manifest:
        fired_at = None if shot.fired_at is None else shot.fired_at.isoformat()
        yield "fired_at", fired_at, manifest["fired_at"]
    if "outcome" not in manifest:
        return
    outcome = outcome_document(shot)
    if frames:
        yield "lost", shot.lost, len(frames["lost"])
        # Each analysis changes the state of a shot with frames.
        outcome = {name: outcome[name] for name in ("state", "fired")}
    yield from _common("", outcome, manifest["outcome"])
    if shot.outcome is not ShotState.STORED:
        yield "state", str(shot.state), manifest["outcome"]["state"]


def _common(prefix: str, row: Json, stated: Json) -> Iterator[tuple[str, object, object]]:
    for name in row.keys() & stated.keys() - _EDITED:
        if isinstance(row[name], dict):
            yield from _common(f"{name}.", row[name], stated[name])
        else:
            yield f"{prefix}{name}", row[name], stated[name]
