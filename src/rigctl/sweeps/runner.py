"""The sweeps of one rig: accepted, run one at a time, paused, resumed, closed after a crash."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from dataclasses import replace

from rigctl.config import Configuration
from rigctl.errors import RefusedError, RigError
from rigctl.listeners import Listeners
from rigctl.rig.clock import SYSTEM_CLOCK, Clock
from rigctl.rig.machine import Rig
from rigctl.rig.states import LATCHED
from rigctl.store import NewSweep, StepState, Store, SweepRecord, SweepState
from rigctl.sweeps.orders import Order, Orders, Wish
from rigctl.sweeps.plan import Plan, require_possible, warnings_of
from rigctl.sweeps.run import Ending, SweepRun
from rigctl.sweeps.status import SweepStatus
from rigctl.sweeps.stepping import end_taken

_log = logging.getLogger(__name__)

_DEVICES_WAIT_S = 20.0

PAUSE_WAIT_S = 5.0
"""Longest wait of a resume for a requested pause to take effect, s."""


def _in_thread(work: Callable[[], None]) -> threading.Thread:
    thread = threading.Thread(target=work, name="sweep", daemon=True)
    thread.start()
    return thread


class SweepRunner:
    """Runs the sweeps that the store keeps; any thread may call any method.

    One sweep runs at a time, in a thread of its own. Everything needed after a crash is on disk
    before the rig moves. `recover` comes first, after the rig's own. `listeners` are called with
    the `SweepStatus` at every change.

    Parameters
    ----------
    rig, store
        Opened by the caller, who closes them after `close`.
    configuration
        Its limits bound what a sweep may ask for, and how long a step may take.
    clock
        Time.
    idle
        Waits for an event, at most so many seconds.
    spawn
        Starts the work of a sweep and returns its thread.
    """

    def __init__(
        self,
        rig: Rig,
        store: Store,
        configuration: Configuration,
        *,
        clock: Clock = SYSTEM_CLOCK,
        idle: Callable[[threading.Event, float], object] = threading.Event.wait,
        spawn: Callable[[Callable[[], None]], threading.Thread] = _in_thread,
    ) -> None:
        self.listeners: Listeners[SweepStatus] = Listeners()
        self._rig, self._store, self._configuration = rig, store, configuration
        self._clock, self._idle, self._spawn = clock, idle, spawn
        self._lock = threading.RLock()
        self._run: SweepRun | None = None
        self._thread: threading.Thread | None = None
        self._unstored: dict[str, Ending] = {}
        self._closed = False

    def recover(self) -> tuple[SweepRecord, ...]:
        """Close what the last daemon left open; return every sweep that offers to go on.

        Nothing is fired. Called once, after the rig has recovered.

        Raises
        ------
        StoreError
            The store cannot be read or written.
        """
        now = self._clock.wall()
        with self._lock:
            for sweep in self._store.sweeps.sweeps(state=SweepState.RUNNING, limit=1000):
                ended = end_taken(self._store, sweep.id, now)
                unknown = [step for step in ended if step.state is StepState.UNKNOWN]
                reason = "the daemon ended; resume it to go on at the next step that has not fired"
                for step in unknown:
                    reason = (
                        f"the daemon ended; whether step {step.number} (shot {step.shot}) fired is "
                        "not known: look at the tubes, release the rig, then resume the sweep"
                    )
                self._store.sweeps.move(sweep.id, SweepState.PAUSED, reason, now)
            return tuple(self._store.sweeps.sweeps(state=SweepState.PAUSED, limit=1000))

    def start(self, plan: Plan, key: str, body_hash: str, actor: str) -> SweepStatus:
        """Claim the key, put the sweep with all its steps on disk, and run it; return at once.

        A key that was used with the same body answers with its sweep and starts nothing.

        Raises
        ------
        SettingsError
            A step lies outside the rig's limits.
        RefusedError
            Another sweep runs, or the rig waits for a person.
        KeyReusedError
            The key was used with another body.
        StoreError
            The sweep is not on disk.
        """
        require_possible(plan, self._configuration.limits)

        def describe() -> NewSweep:
            self._require_free()
            return NewSweep(
                steps=plan.steps,
                form=plan.form,
                rules=plan.rules.to_json(),
                campaign=plan.campaign,
                actor=actor,
                accepted_at=self._clock.wall(),
            )

        with self._lock:
            sweep, known = self._store.sweeps.accept(key, body_hash, describe)
            if not known:
                self._begin(sweep)
        return replace(self.status(sweep.id), warnings=warnings_of(plan, self._configuration))

    def pause(self, sweep: str, actor: str) -> SweepStatus:
        """Fire nothing more of a sweep until it is resumed; a shot under way still ends.

        Raises
        ------
        NotFoundError, RefusedError
            There is no such sweep, or it has ended.
        """
        with self._lock:
            if not self._order(sweep, Order(Wish.PAUSE, f"paused by {actor}")):
                self._require_state(sweep, SweepState.PAUSED)
        return self._notified(sweep)

    def abort(self, sweep: str, actor: str) -> SweepStatus:
        """Give a sweep up; a shot under way still ends, and the pressure is taken away.

        Where somebody else arms or uses the rig meanwhile, it is left to them.

        Raises
        ------
        NotFoundError, RefusedError
            There is no such sweep, or it was completed.
        StoreError
            It is not on disk.
        """
        reason = f"aborted by {actor}"
        if self.status(sweep).record.state is SweepState.PAUSED:
            reason = self._rested(reason)
        with self._lock:
            if not self._order(sweep, Order(Wish.ABORT, reason)):
                present = self.status(sweep).record.state
                if present is not SweepState.ABORTED:
                    self._require_state(sweep, SweepState.PAUSED)
                    self._settle(sweep)
                    now = self._clock.wall()
                    self._store.sweeps.move(sweep, SweepState.ABORTED, reason, now)
        return self._notified(sweep)

    def resume(self, sweep: str, actor: str) -> SweepStatus:
        """Let a paused sweep go on at its next step that has not fired.

        Where the pause still waits for the end of a shot, so does this, at most `PAUSE_WAIT_S`.

        Raises
        ------
        NotFoundError, RefusedError
            There is no such sweep; it is not paused, another one runs, or the rig waits for a
            person.
        StoreError
            It is not on disk.
        """
        with self._lock:
            run, thread = self._run, self._thread
        if run is not None and run.sweep == sweep and run.orders.order and thread is not None:
            thread.join(PAUSE_WAIT_S)
        with self._lock:
            self._require_free()
            self._require_state(sweep, SweepState.PAUSED)
            self._settle(sweep)
            now = self._clock.wall()
            running = SweepState.RUNNING
            record = self._store.sweeps.move(sweep, running, f"resumed by {actor}", now)
            self._begin(record)
        return self.status(sweep)

    def status(self, sweep: str) -> SweepStatus:
        """Return the status of a sweep; raise `NotFoundError` if there is none of that name."""
        with self._lock:
            record, run = self._store.sweeps.sweep(sweep), self._run
            if run is None or run.sweep != sweep:
                ending = self._unstored.get(sweep)
                return SweepStatus(record if ending is None else _as_ended(record, ending))
        order = run.orders.order
        waiting = record.counts.get(StepState.WAITING, 0) + record.counts.get(StepState.TAKEN, 0)
        return SweepStatus(
            record,
            asked=None if order is None else order.wish,
            step=run.step,
            left_s=run.left_s(waiting),
            mean=run.mean,
        )

    def wait(self, timeout_s: float) -> bool:
        """Wait until no sweep runs, or the time is over; return whether none does."""
        thread = self._thread
        if thread is not None:
            thread.join(timeout_s)
        return thread is None or not thread.is_alive()

    def close(self) -> None:
        """Pause the sweep that runs, within the bounds of a shot. Never raises."""
        with self._lock:
            self._closed = True
            if self._run is not None:
                reason = "the daemon ended; resume it to go on at the next step that has not fired"
                self._run.orders.give(Order(Wish.PAUSE, reason))
        if not self.wait(self._longest_step_s):
            _log.error("the sweep did not pause within %g s", self._longest_step_s)

    @property
    def _longest_step_s(self) -> float:
        limits, camera = self._configuration.limits, self._configuration.camera
        shot = camera.start_timeout_s + camera.collect_timeout_s
        return limits.settle_timeout_s + shot + _DEVICES_WAIT_S

    def _begin(self, sweep: SweepRecord) -> None:
        self._unstored.pop(sweep.id, None)
        run = SweepRun(
            self._rig,
            self._store,
            self._clock,
            sweep,
            orders=Orders(self._idle),
            changed=lambda: self._tell(sweep.id),
        )
        self._run = run
        self._tell(sweep.id)
        try:
            self._thread = self._spawn(lambda: self._work(run))
        except RuntimeError as error:
            self._run = None
            reason = f"its thread could not be started: {error}"
            self._store.sweeps.move(sweep.id, SweepState.PAUSED, reason, self._clock.wall())
            raise RefusedError(
                reason,
                part=f"sweep {sweep.id}",
                todo="end other programs on the host, then resume it",
            ) from error

    def _work(self, run: SweepRun) -> None:
        try:
            ending = run.run()
        except RigError as error:
            ending = Ending(SweepState.PAUSED, str(error))
        except Exception as error:  # noqa: BLE001 - the sweep must be seen to have stopped
            _log.exception("sweep %s", run.sweep)
            ending = Ending(SweepState.PAUSED, f"an error in the program: {error!r}")
        if ending.state is SweepState.ABORTED:
            ending = replace(ending, reason=self._rested(ending.reason))
        with self._lock:
            self._run = None
            try:
                now = self._clock.wall()
                self._store.sweeps.move(run.sweep, ending.state, ending.reason, now)
            except RigError as error:
                _log.exception("sweep %s: its end is not on disk", run.sweep)
                why = f"{ending.reason} (not on disk: {error})"
                self._unstored[run.sweep] = Ending(SweepState.PAUSED, why)
        self._tell(run.sweep)

    def _rested(self, reason: str) -> str:
        """Bring the rig to rest; return the reason with what became of its devices."""
        done = self._rig.rest()
        return f"{reason}; {done}" if done else reason

    def _tell(self, sweep: str) -> None:
        try:
            self.listeners.notify(self.status(sweep))
        except RigError:
            _log.exception("sweep %s: its listeners could not be called", sweep)

    def _notified(self, sweep: str) -> SweepStatus:
        status = self.status(sweep)
        self.listeners.notify(status)
        return status

    def _order(self, sweep: str, order: Order) -> bool:
        """Hand an order to the sweep if it runs; return whether it does."""
        if self._run is None or self._run.sweep != sweep:
            return False
        self._run.orders.give(order)
        return True

    def _settle(self, sweep: str) -> None:
        """Write down what a run could not: the ends of its steps, and its own."""
        now = self._clock.wall()
        end_taken(self._store, sweep, now)
        if self._store.sweeps.sweep(sweep).state is SweepState.RUNNING:
            self._store.sweeps.move(sweep, SweepState.PAUSED, "its end was not on disk", now)
        self._unstored.pop(sweep, None)

    def _require_free(self) -> None:
        if self._closed:
            raise RefusedError("the daemon ends", todo="start it again")
        if self._run is not None:
            raise RefusedError(
                "a sweep runs",
                part=f"sweep {self._run.sweep}",
                todo="pause or abort it, and wait for the end of its shot",
            )
        status = self._rig.status()
        if status.state in LATCHED:
            raise RefusedError(
                f"the rig is {status.state}: {status.latch_reason}",
                todo="release the rig with a reason",
            )

    def _require_state(self, sweep: str, required: SweepState) -> None:
        state = self.status(sweep).record.state
        if state is not required:
            raise RefusedError(
                f"the sweep is {state}",
                part=f"sweep {sweep}",
                limit=str(required),
                todo="list the sweeps",
            )


def _as_ended(record: SweepRecord, ending: Ending) -> SweepRecord:
    return replace(record, state=ending.state, reason=ending.reason)
