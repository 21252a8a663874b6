"""The states of one shot, and the one table of what may follow what."""

from __future__ import annotations

from enum import StrEnum


class ShotState(StrEnum):
    """State of a shot.

    ::

        accepted --> firing --> capturing --> stored --> analysing --> analysed
           |           |            |                        |  ^
           |           |            |                        v  | (analysed again)
           |           |            +--> aborted          refused
           |           +--> misfire, unknown_outcome, aborted
           +--> aborted                (a crash: interrupted, unknown_outcome)

    `accepted`: the key is claimed, nothing was sent. `firing`: the intent is on disk, and the
    fire command may be on its way. `capturing`: the trigger confirmed. `aborted`: given up, and
    the record shows whether the spheres flew. `misfire`: the trigger refused, nothing flew.
    `interrupted`: the daemon died around it. `refused`: the frames could not be measured.
    """

    ACCEPTED = "accepted"
    FIRING = "firing"
    CAPTURING = "capturing"
    STORED = "stored"
    ANALYSING = "analysing"
    ANALYSED = "analysed"
    REFUSED = "refused"
    MISFIRE = "misfire"
    UNKNOWN_OUTCOME = "unknown_outcome"
    ABORTED = "aborted"
    INTERRUPTED = "interrupted"


class Fired(StrEnum):
    """Whether the spheres flew, as far as it is known."""

    NO = "no"
    YES = "yes"
    UNKNOWN = "unknown"


SHOT_TRANSITIONS: dict[ShotState, frozenset[ShotState]] = {
    ShotState.ACCEPTED: frozenset({ShotState.FIRING, ShotState.ABORTED, ShotState.INTERRUPTED}),
    ShotState.FIRING: frozenset(
        {ShotState.CAPTURING, ShotState.MISFIRE, ShotState.UNKNOWN_OUTCOME, ShotState.ABORTED}
    ),
    ShotState.CAPTURING: frozenset({ShotState.STORED, ShotState.ABORTED, ShotState.INTERRUPTED}),
    ShotState.STORED: frozenset({ShotState.ANALYSING}),
    ShotState.ANALYSING: frozenset({ShotState.ANALYSED, ShotState.REFUSED, ShotState.STORED}),
    ShotState.ANALYSED: frozenset({ShotState.ANALYSING}),
    ShotState.REFUSED: frozenset({ShotState.ANALYSING}),
    ShotState.MISFIRE: frozenset(),
    ShotState.UNKNOWN_OUTCOME: frozenset(),
    ShotState.ABORTED: frozenset(),
    ShotState.INTERRUPTED: frozenset(),
}

RUNNING = frozenset({ShotState.ACCEPTED, ShotState.FIRING, ShotState.CAPTURING})
"""States in which the rig itself is still busy with the shot."""
