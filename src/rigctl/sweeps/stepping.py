"""One step: arm, let it settle, take the step on disk, fire once, record the outcome on disk."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass

from rigctl.errors import ArmTokenError, InterlockError, RigError
from rigctl.rig.clock import Clock
from rigctl.rig.machine import Rig
from rigctl.rig.states import LATCHED
from rigctl.store import StepRecord, StepState, Store, SweepRecord
from rigctl.sweeps.orders import Orders
from rigctl.sweeps.step_outcome import actor_of, end_step, is_own


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
