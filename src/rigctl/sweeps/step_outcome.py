"""Outcome of a step by the record of its shot; the same while running and after a crash."""

from __future__ import annotations

from datetime import datetime

from rigctl.errors import RefusedError
from rigctl.store import Fired, ShotRecord, ShotState, StepRecord, StepState, Store


def state_after(shot: ShotRecord) -> StepState:
    """Return the state of the step whose shot has ended so; what is doubtful is `unknown`."""
    if shot.outcome is ShotState.STORED:
        return StepState.STORED
    if shot.outcome is ShotState.UNKNOWN_OUTCOME or shot.fired is Fired.UNKNOWN:
        return StepState.UNKNOWN
    return StepState.LOST if shot.fired is Fired.YES else StepState.NOT_FIRED


def actor_of(sweep: str, actor: str) -> str:
    """Return the actor of a sweep's shots, from the sweep and the person who requested it."""
    return f"{_fired_by(sweep)}{actor}"


def is_own(shot: ShotRecord, sweep: str) -> bool:
    """Whether a sweep fired this shot itself; no caller may have such a name."""
    return shot.actor.startswith(_fired_by(sweep))


def _fired_by(sweep: str) -> str:
    return f"sweep {sweep} of "


def end_step(store: Store, sweep: str, step: StepRecord, now: datetime) -> StepRecord:
    """Record the outcome of a taken step; nothing is fired.

    A key that made no shot proves that nothing was accepted, and so nothing was fired.

    Raises
    ------
    RefusedError
        Its shot has not ended.
    StoreError
        The store cannot be read or written.
    """
    shot = store.catalogue.of_key(step.key or "")
    if shot is None:
        why = "the sweep was cut off before a shot was accepted"
        return store.sweeps.end(sweep, step.number, StepState.NOT_FIRED, now, failure=why)
    if not is_own(shot, sweep):
        why = f"shot {shot.id} of {shot.actor} has the key of the step; the sweep fired nothing"
        return store.sweeps.end(sweep, step.number, StepState.NOT_FIRED, now, failure=why)
    if shot.outcome is None:
        raise RefusedError(
            f"the shot of step {step.number} has not ended", shot=shot.id, todo="wait for its end"
        )
    return store.sweeps.end(
        sweep, step.number, state_after(shot), now, shot=shot.id, failure=shot.failure
    )


def end_taken(store: Store, sweep: str, now: datetime) -> list[StepRecord]:
    """Record the outcome of every step that is still taken; as `end_step`."""
    return [
        end_step(store, sweep, step, now) for step in store.sweeps.steps(sweep, StepState.TAKEN)
    ]
