"""The states of a sweep and of its steps, and the tables of what may follow what."""

from __future__ import annotations

from enum import StrEnum


class SweepState(StrEnum):
    """State of a sweep.

    ::

        running <--> paused --> aborted
           |                       ^
           +--> completed          |
           +-----------------------+

    `running`: the daemon goes on by itself. `paused`: nothing is fired until somebody resumes it;
    a stop condition, a device's failure and the end of the daemon lead here too. `completed`: no
    step waits any more, or what was to be known is known. `aborted`: given up for good.
    """

    RUNNING = "running"
    PAUSED = "paused"
    COMPLETED = "completed"
    ABORTED = "aborted"


SWEEP_TRANSITIONS: dict[SweepState, frozenset[SweepState]] = {
    SweepState.RUNNING: frozenset({SweepState.PAUSED, SweepState.COMPLETED, SweepState.ABORTED}),
    SweepState.PAUSED: frozenset({SweepState.RUNNING, SweepState.ABORTED}),
    SweepState.COMPLETED: frozenset(),
    SweepState.ABORTED: frozenset(),
}


class StepState(StrEnum):
    """State of one step of a sweep.

    ::

        waiting --> taken --> stored, lost, unknown
         ^  |         |
         |  |         +--> not_fired
         |  |                  |
         +--|------------------+  (when the sweep is resumed)
            +--> skipped

    `taken`: its idempotency key is on disk, and its shot may exist; the table of keys has it if it
    does. `stored`: the frames are on disk. `lost`: the spheres flew, the frames are lost.
    `not_fired`: certainly nothing flew. `unknown`: not decidable. `skipped`: the sweep ended
    before its turn. A step whose spheres flew, or may have, is never fired again.
    """

    WAITING = "waiting"
    TAKEN = "taken"
    STORED = "stored"
    LOST = "lost"
    NOT_FIRED = "not_fired"
    UNKNOWN = "unknown"
    SKIPPED = "skipped"


STEP_TRANSITIONS: dict[StepState, frozenset[StepState]] = {
    StepState.WAITING: frozenset({StepState.TAKEN, StepState.SKIPPED}),
    StepState.TAKEN: frozenset(
        {StepState.STORED, StepState.LOST, StepState.NOT_FIRED, StepState.UNKNOWN}
    ),
    StepState.NOT_FIRED: frozenset({StepState.WAITING}),
    StepState.STORED: frozenset(),
    StepState.LOST: frozenset(),
    StepState.UNKNOWN: frozenset(),
    StepState.SKIPPED: frozenset(),
}

FAILED = frozenset({StepState.LOST, StepState.NOT_FIRED, StepState.UNKNOWN})
"""States of a step that came to nothing."""
