"""One sweep from its next waiting step to its end, or until something holds it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rigctl.rig.clock import Clock
from rigctl.rig.machine import Rig
from rigctl.store import StepRecord, StepState, Store, SweepRecord, SweepState
from rigctl.store.sweep_states import FAILED
from rigctl.sweeps.choice import best
from rigctl.sweeps.coefficient import Mean, Measured
from rigctl.sweeps.orders import Orders, Wish
from rigctl.sweeps.pace import Pace
from rigctl.sweeps.plan import Rules
from rigctl.sweeps.stepping import Stepper


@dataclass(frozen=True, slots=True)
class Ending:
    """How a run ended: the sweep's next state and its reason."""

    state: SweepState
    reason: str


_AFTER = {Wish.PAUSE: SweepState.PAUSED, Wish.ABORT: SweepState.ABORTED}


class SweepRun:
    """Runs a sweep in the thread that calls `run`; its attributes may be read from any thread.

    Attributes
    ----------
    orders
        What people ask of it.
    step
        The step under way, or None.
    mean
        The coefficient that may end it, as known so far, or None.
    """

    def __init__(
        self,
        rig: Rig,
        store: Store,
        clock: Clock,
        sweep: SweepRecord,
        *,
        orders: Orders,
        changed: Callable[[], None],
    ) -> None:
        self.sweep, self.orders = sweep.id, orders
        self.step: StepRecord | None = None
        self.mean: Mean | None = None
        self._store, self._clock, self._changed = store, clock, changed
        self._rules = Rules.from_json(sweep.rules)
        self._stepper = Stepper(rig, store, clock, sweep, self._rules.settle_s)
        self._pace = Pace(clock.monotonic())
        self._stored = store.sweeps.steps(sweep.id, StepState.STORED)
        self._measured: Measured | None = None
        if (until := self._rules.until) is not None:
            shots = [str(step.shot) for step in self._stored]
            self._measured = Measured(store, until.coefficient, shots)

    def run(self) -> Ending:
        """Fire step after step; return why it ends. Nothing is armed then.

        Raises
        ------
        StoreError
            The store cannot be read.
        """
        try:
            return self._run()
        finally:
            if self._measured is not None:
                self._measured.close()

    def left_s(self, waiting: int) -> float | None:
        """Return the estimated time to the end, s, with so many steps waiting.

        A coefficient's standard error falls with the square root of the number of shots.
        """
        until, mean = self._rules.until, self.mean
        if until is not None and mean is not None and mean.own is not None:
            wanted = mean.shots * ((mean.own / until.sigma) ** 2 - 1)
            waiting = min(waiting, max(0, round(wanted)))
        return self._pace.left_s(waiting)

    def _run(self) -> Ending:
        failed = 0
        while True:
            if (ending := self._over()) is not None:
                return ending
            step = self._next()
            if step is None:
                return self._completed("no step waits any more")
            try:
                end = self._stepper.fire(step, self.orders, self._taken)
            finally:
                self.step = None
            if end.step.state is not StepState.WAITING:
                self._pace.step_ended(self._clock.monotonic())
            if end.step.state is StepState.STORED:
                self._stored.append(end.step)
            self._changed()
            if end.hold is not None:
                return Ending(SweepState.PAUSED, end.hold)
            if end.step.state is not StepState.WAITING:
                failed = failed + 1 if end.step.state in FAILED else 0
            if failed >= self._rules.most_failed:
                why = f"{failed} steps in a row came to nothing, the last: {end.step.failure}"
                return Ending(SweepState.PAUSED, why)
            self.orders.wait(self._rules.pause_s)

    def _taken(self, step: StepRecord) -> None:
        self.step = step
        self._changed()

    def _over(self) -> Ending | None:
        order = self.orders.order
        if order is not None:
            return Ending(_AFTER[order.wish], order.reason)
        until = self._rules.until
        if until is None or self._measured is None:
            return None
        self.mean = mean = self._measured.mean([str(step.shot) for step in self._stored])
        if mean is None or mean.own is None or mean.own > until.sigma:
            return None
        shared = f", and {mean.common:.2g} by what all shots share" if mean.common > 0 else ""
        return self._completed(
            f"{mean.coefficient} is {mean.value:.6g} with a standard error of {mean.own:.2g}, "
            f"{until.sigma:g} was asked for{shared}"
        )

    def _completed(self, reason: str) -> Ending:
        return Ending(SweepState.COMPLETED, reason)

    def _next(self) -> StepRecord | None:
        measured = self._measured
        if not self._rules.adaptive or measured is None:
            return self._store.sweeps.next_step(self.sweep)
        waiting = self._store.sweeps.steps(self.sweep, StepState.WAITING)
        if not waiting:
            return None
        told = []
        for step in self._stored:
            estimate, ended = measured.of(str(step.shot))
            if ended:
                told.append((step.settings, estimate.own**-2 if estimate else 0.0))
        return waiting[best([step.settings for step in waiting], told)]
