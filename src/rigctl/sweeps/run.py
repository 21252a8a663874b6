"""One sweep from its next waiting step to its end, or until something holds it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigctl.rig.clock import Clock
from rigctl.rig.machine import Rig
from rigctl.settings import ShotSettings
from rigctl.store import StepRecord, StepState, Store, SweepRecord, SweepState
from rigctl.store.sweep_states import FAILED
from rigctl.sweeps.coefficient import Mean, Measured
from rigctl.sweeps.orders import Orders, Wish
from rigctl.sweeps.plan import Rules
from rigctl.sweeps.stepping import Stepper

REMEMBERED = 16
"""Steps over which the pace is averaged: enough to be steady, few enough to follow a change."""


class Pace:
    """Mean time from the end of one step to the end of the next, s."""

    def __init__(self, began: float) -> None:
        self._ended: deque[float] = deque([began], maxlen=REMEMBERED + 1)

    def step_ended(self, at: float) -> None:
        """Note the monotonic time (s) at which a step ended."""
        self._ended.append(at)

    def left_s(self, steps: int) -> float | None:
        """Return how long so many steps will take, s; None before the first has ended."""
        cycles = len(self._ended) - 1
        if cycles == 0:
            return None
        return steps * (self._ended[-1] - self._ended[0]) / cycles


SPREAD = 8
"""Distinct settings measured in the sweep's own order before anything is chosen."""

WIDTH = 0.2
"""Width of the kernel by which a shot informs its neighbours, as a share of the sweep's range."""

PRIOR = 0.1
"""Weight of the plain mean of all shots, against 1 of a shot at the settings themselves."""


def best(waiting: Sequence[ShotSettings], analysed: Sequence[tuple[ShotSettings, float]]) -> int:
    """Return the index of the waiting settings with the highest expected information.

    Information is 1 / sigma^2 of the coefficient from one shot, and 0 of one that could not be
    measured. What is expected of settings is the mean over all shots, weighted by a Gaussian of
    their distance with each setting scaled to its range in the sweep; far from all shots it is
    their plain mean. The first comes first among equals, and as long as fewer than `SPREAD`
    distinct settings have been measured.

    Parameters
    ----------
    waiting
        Settings of the steps that wait, in the sweep's order; at least one.
    analysed
        Settings of each shot whose analysis has ended, and its information.
    """
    fired = _places([settings for settings, _ in analysed])
    if len(np.unique(fired, axis=0)) < SPREAD:
        return 0
    places = _places(waiting)
    ranges = np.ptp(np.concatenate([places, fired]), axis=0)
    ranges[ranges == 0.0] = 1.0
    apart = (places[:, None] - fired[None]) / ranges
    weights = np.exp(-0.5 * np.sum(apart**2, axis=2) / WIDTH**2)
    information = np.array([each for _, each in analysed])
    near = np.sum(weights, axis=1)
    expected = (weights @ information + PRIOR * np.mean(information)) / (near + PRIOR)
    # Rounding must not choose among equals.
    return int(np.argmax(expected >= np.max(expected) * (1.0 - 1e-9)))


def _places(settings: Sequence[ShotSettings]) -> NDArray[np.float64]:
    """Return the settings as points (n, 3)."""
    points = [(each.pressure_a_kpa, each.pressure_b_kpa, each.offset_mm) for each in settings]
    return np.array(points, dtype=np.float64).reshape(-1, 3)


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
        Orders of people.
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
            needed = mean.shots * ((mean.own / until.sigma) ** 2 - 1)
            waiting = min(waiting, max(0, round(needed)))
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
        analysed = []
        for step in self._stored:
            estimate, ended = measured.of(str(step.shot))
            if ended:
                analysed.append((step.settings, estimate.own**-2 if estimate else 0.0))
        return waiting[best([step.settings for step in waiting], analysed)]
