"""What the rig says of itself, as unchangeable snapshots."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from rigctl.rig.interlocks import Interlock
from rigctl.rig.states import RigState
from rigctl.settings import ShotSettings
from rigctl.store.records import ShotRecord


@dataclass(frozen=True, slots=True)
class Transition:
    """One step of the rig, as listeners are told: from where to where, when (UTC), who and why."""

    before: RigState
    after: RigState
    at: datetime
    actor: str
    reason: str
    shot: str | None


@dataclass(frozen=True, slots=True)
class RigStatus:
    """The rig at one moment.

    Attributes
    ----------
    name, apparatus, simulated
        Which rig, and whether anything real can move.
    state, since, reason
        Where it stands, since when (UTC), and why it went there.
    settings
        Those of the last arm request; None before the first.
    token_expires_at
        UTC, for people; None when no arm token is live.
    token_ends_s
        The same moment in monotonic seconds, which decide.
    interlocks, read_at
        The conditions as last read, and the monotonic time (s) of this snapshot, from which
        their ages count.
    running
        The shot in progress.
    last_shot
        The shot accepted last, as it now stands.
    latch_reason
        Why a person has to release the rig; None when nobody has to.
    warnings
        What the operator must know about this apparatus.
    """

    name: str
    apparatus: str
    simulated: bool
    state: RigState
    since: datetime
    reason: str
    settings: ShotSettings | None
    token_expires_at: datetime | None
    token_ends_s: float | None
    interlocks: tuple[Interlock, ...]
    read_at: float
    running: str | None
    last_shot: ShotRecord | None
    latch_reason: str | None
    warnings: tuple[str, ...]
