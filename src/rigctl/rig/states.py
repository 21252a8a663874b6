"""The states of the rig, and the one table of what may follow what."""

from __future__ import annotations

from enum import StrEnum

from rigctl.errors import RefusedError
from rigctl.store.states import Fired, ShotState

__all__ = [
    "LATCHED",
    "TOWARD_FIRE",
    "TRANSITIONS",
    "Fired",
    "RigState",
    "ShotState",
    "require_move",
]


class RigState(StrEnum):
    """Where the rig stands.

    ::

        idle --> checked --> armed --> firing --> capturing --> stored
         ^          |          |        | | |         |
         +- refused +- expired +        | | +-> aborted
         |                              | +---> misfire
         |                              +-----> unknown_outcome
         |
         +-- safe state reached: from stored, aborted, misfire
         +-- a person, with a reason: from unknown_outcome, fault, estop

    `checked`: settings reached, every interlock holds. `armed`: a token is live. `firing`: the
    token is spent. `capturing`: the trigger confirmed. `stored`: the frames are on disk. `fault`
    follows wherever a device or the store failed, once the shot, if any, has ended.
    `estop` follows every state, at once. `aborted`: given up before the byte left, or without
    frames after it. `misfire`: the trigger refused. `unknown_outcome`: the byte left and nobody
    can say what it did.
    """

    IDLE = "idle"
    CHECKED = "checked"
    ARMED = "armed"
    FIRING = "firing"
    CAPTURING = "capturing"
    STORED = "stored"
    ABORTED = "aborted"
    MISFIRE = "misfire"
    UNKNOWN_OUTCOME = "unknown_outcome"
    FAULT = "fault"
    ESTOP = "estop"


TRANSITIONS: dict[RigState, frozenset[RigState]] = {
    RigState.IDLE: frozenset({RigState.CHECKED, RigState.FAULT, RigState.ESTOP}),
    RigState.CHECKED: frozenset({RigState.ARMED, RigState.IDLE, RigState.FAULT, RigState.ESTOP}),
    RigState.ARMED: frozenset({RigState.FIRING, RigState.IDLE, RigState.FAULT, RigState.ESTOP}),
    RigState.FIRING: frozenset(
        {
            RigState.CAPTURING,
            RigState.ABORTED,
            RigState.MISFIRE,
            RigState.UNKNOWN_OUTCOME,
            RigState.ESTOP,
        }
    ),
    RigState.CAPTURING: frozenset({RigState.STORED, RigState.ABORTED, RigState.ESTOP}),
    RigState.STORED: frozenset({RigState.IDLE, RigState.FAULT, RigState.ESTOP}),
    RigState.ABORTED: frozenset({RigState.IDLE, RigState.FAULT, RigState.ESTOP}),
    RigState.MISFIRE: frozenset({RigState.IDLE, RigState.FAULT, RigState.ESTOP}),
    RigState.UNKNOWN_OUTCOME: frozenset({RigState.IDLE, RigState.ESTOP}),
    RigState.FAULT: frozenset({RigState.IDLE, RigState.ESTOP}),
    RigState.ESTOP: frozenset({RigState.IDLE, RigState.ESTOP}),
}

LATCHED = frozenset({RigState.UNKNOWN_OUTCOME, RigState.FAULT, RigState.ESTOP})
"""States that only a person leaves, by `Rig.release` and with a reason."""

TOWARD_FIRE = frozenset({RigState.CHECKED, RigState.ARMED, RigState.FIRING})
"""States that are not entered unless the audit holds the step."""


def require_move(before: RigState, after: RigState, *, released: bool = False) -> None:
    """Check a transition against the table.

    `released` says that a person gave a reason for leaving a latched state.

    Raises
    ------
    RefusedError
        The table does not hold the transition, or a latched state would be left by itself.
    """
    if after not in TRANSITIONS[before]:
        raise RefusedError(
            f"the rig is {before} and cannot become {after}",
            value=before,
            limit=", ".join(sorted(TRANSITIONS[before])),
            todo="release the rig with a reason" if before in LATCHED else "wait for the rig",
        )
    if before in LATCHED and after is not RigState.ESTOP and not released:
        raise RefusedError(
            f"the rig is {before}, which a person ends", todo="release the rig with a reason"
        )
