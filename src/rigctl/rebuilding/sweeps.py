"""Sweeps, from their files and from the shots that they fired."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from rigctl.rebuilding.fired import FiredShot
from rigctl.settings import ShotSettings
from rigctl.store.states import Fired, ShotState
from rigctl.store.sweep_states import StepState, SweepState

Json = dict[str, Any]
Rows = list[dict[str, object]]

REASON = "the catalogue was rebuilt; start a further sweep for the steps that were not fired"
_NOTE = re.compile(r"sweep (?P<sweep>\S+), step (?P<step>\d+)")


def sweep_rows(document: Json, shots: Iterable[FiredShot], now: str) -> tuple[Json, Rows]:
    """Return the row of a sweep and those of its steps.

    A sweep that did not end before the catalogue was lost is over: nobody resumes it unseen.
    """
    steps: Rows = [
        {
            "sweep": document["number"],
            "number": number,
            "settings": ShotSettings.model_validate(settings).model_dump_json(),
            "state": StepState.SKIPPED,
            "attempt": 0,
        }
        for number, settings in enumerate(document["steps"], start=1)
    ]
    for shot in shots:
        match = _NOTE.fullmatch(str(shot.row["note"] or ""))
        own = str(shot.row["actor"]).startswith(f"sweep {document['id']} of ")
        if match and own and match["sweep"] == document["id"]:
            steps[int(match["step"]) - 1] |= _fired(shot)
    left = any(step["state"] is StepState.SKIPPED for step in steps)
    row = {name: document[name] for name in _COLUMNS} | {
        "id": document["id"],
        "state": SweepState.ABORTED if left else SweepState.COMPLETED,
        "reason": REASON if left else "no step waits any more",
        "ended_at": now,
    }
    return row, steps


_COLUMNS = (
    "number",
    "key",
    "body_hash",
    "form",
    "rules",
    "campaign",
    "actor",
    "accepted_at",
)


def _fired(shot: FiredShot) -> dict[str, object]:
    outcome, fired = shot.row["outcome"], shot.row["fired"]
    if outcome is ShotState.STORED:
        state = StepState.STORED
    elif fired is Fired.UNKNOWN:
        state = StepState.UNKNOWN
    else:
        state = StepState.LOST if fired is Fired.YES else StepState.NOT_FIRED
    return {
        "state": state,
        "attempt": 1,
        "key": None if shot.request is None else shot.request.key,
        "shot": shot.row["id"],
        "taken_at": shot.row["accepted_at"],
        "ended_at": shot.row["ended_at"],
        "failure": shot.row["failure"],
    }
