"""One step: arm, let it settle, take the step on disk, fire once; its outcome by its shot."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime

from rigctl.errors import ArmTokenError, InterlockError, RefusedError, RigError
from rigctl.rig.clock import Clock
from rigctl.rig.machine import Rig
from rigctl.rig.states import LATCHED
from rigctl.store import Fired, ShotRecord, ShotState, StepRecord, StepState, Store, SweepRecord
from rigctl.sweeps.orders import Orders


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


@dataclass(frozen=True, slots=True)
class StepEnd:
    """What became of a step, and why the sweep must not go on; None when it may."""

    step: StepRecord
    hold: str | None


class Stepper:
    """Fires steps of one sweep in the thread that calls it; each at most once.

    The key of a step is on disk before its shot is accepted, and the rig claims it in the
    transaction that makes the shot: after a crash the table of keys shows whether a shot exists.
    """

    def __init__(
        self, rig: Rig, store: Store, clock: Clock, sweep: SweepRecord, settle_s: float
    ) -> None:
        self._rig, self._store, self._clock = rig, store, clock
        self._sweep, self._settle_s = sweep, settle_s
        self._actor = actor_of(sweep.id, sweep.actor)

    def fire(
        self, step: StepRecord, orders: Orders, taken: Callable[[StepRecord], None]
    ) -> StepEnd:
        """Fire one waiting step, unless an order comes before the fire; return when it has ended.

        `taken` is called with the step once its key is on disk. What fails before that leaves the
        step waiting; whatever fails, its reason comes back in `hold` and nothing stays armed.
        """
        try:
            token = self._rig.arm(step.settings, self._actor).token
        except RigError as error:
            return StepEnd(step, f"step {step.number} could not be armed: {error}")
        try:
            orders.wait(self._settle_s)
            if orders.order is not None:
                self._rig.disarm(self._actor, orders.order.reason)
                return StepEnd(step, None)
            step = self._store.sweeps.take(self._sweep.id, step.number, self._clock.wall())
        except RigError as error:
            self._rig.disarm(self._actor, "the step could not be taken")
            return StepEnd(step, f"step {step.number} could not be taken: {error}")
        taken(step)
        return self._fire_taken(step, token)

    def _fire_taken(self, step: StepRecord, token: str) -> StepEnd:
        settings = step.settings.model_dump_json()
        try:
            shot = self._rig.accept(
                token,
                str(step.key),
                hashlib.sha256(settings.encode()).hexdigest(),
                campaign=self._sweep.campaign,
                note=f"sweep {self._sweep.id}, step {step.number}",
                actor=self._actor,
            )
        except RigError as error:
            # A token that no longer holds may have given way to somebody else's, which stays.
            if not isinstance(error, ArmTokenError):
                self._rig.disarm(self._actor, "the shot was not accepted")
            return self._ended(step, f"step {step.number} was not fired: {error}")
        if not is_own(shot, self._sweep.id):
            # The key was used already: nothing was fired, and the token still holds.
            self._rig.disarm(self._actor, "the key of the step was used by somebody else")
            return self._ended(step, None)
        record = self._rig.wait(shot.id)
        interlock = record.failure_code == InterlockError.code
        return self._ended(step, record.failure if interlock else None)

    def _ended(self, step: StepRecord, hold: str | None) -> StepEnd:
        try:
            step = end_step(self._store, self._sweep.id, step, self._clock.wall())
        except RigError as error:
            return StepEnd(step, hold or str(error))
        if step.state is StepState.UNKNOWN:
            hold = (
                f"whether step {step.number} (shot {step.shot}) fired is not known: look at the "
                "tubes, release the rig, then resume the sweep"
            )
        status = self._rig.status()
        if hold is None and status.state in LATCHED:
            hold = f"the rig is {status.state}: {status.latch_reason}"
        return StepEnd(step, hold)
