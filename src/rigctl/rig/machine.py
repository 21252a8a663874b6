"""The one object that may fire."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

from rigctl.cameras.capture import Capture
from rigctl.config import CameraSection, Configuration
from rigctl.devices.roles import Actuators, PowerQuery
from rigctl.errors import DeviceError, InterlockError, RefusedError, RigError
from rigctl.rig.arming import Armed
from rigctl.rig.bounds import misses, require_within
from rigctl.rig.clock import SYSTEM_CLOCK, Clock
from rigctl.rig.conditions import Conditions, adjust
from rigctl.rig.firing import ShotRun
from rigctl.rig.interlocks import Interlock, require
from rigctl.rig.parts import Bench
from rigctl.rig.permit import NoPermitNeeded, Permit
from rigctl.rig.readiness import Readiness
from rigctl.rig.recovery import Recovery, close_running, start
from rigctl.rig.running import ACTOR, RunningShot, in_thread, leave_unanalysed
from rigctl.rig.standing import Standing
from rigctl.rig.states import LATCHED, RigState, ShotState
from rigctl.rig.status import RigStatus
from rigctl.rig.stopping.estop import EmergencyStop
from rigctl.rig.stopping.halting import halt, make_safe, reopen
from rigctl.rig.stopping.latch import CleanEnd
from rigctl.rig.stopping.watch import Watch
from rigctl.rig.taking import Taking
from rigctl.settings import ShotSettings
from rigctl.store.records import ShotRecord
from rigctl.store.store import Store

_log = logging.getLogger(__name__)

_ENDING = frozenset({RigState.STORED, RigState.ABORTED, RigState.MISFIRE})
_DEVICES_WAIT_S = 10.0


def longest_run_s(camera: CameraSection) -> float:
    """Return the longest time from an accepted order to a rig at rest, s."""
    return camera.start_timeout_s + camera.collect_timeout_s + _DEVICES_WAIT_S


class Rig:
    """The rig's state machine; `states.RigState` holds the diagram, beside its one table.

    Any thread may call any method. One lock guards every transition and is never held while a
    device is waited for; the emergency stop cuts without it. One shot runs at a time, in a thread
    of its own. `recover` comes first. `listeners` are told of each `Transition`.

    Parameters
    ----------
    configuration
        What the rig is.
    devices, capture, store
        Opened by the caller, who closes them after `close`.
    clock
        Time.
    analyse
        Told the name of each stored shot; must return at once.
    spawn
        Runs a shot's work; by default in a thread of its own.
    watches
        As `EmergencyStop`.
    permit
        What refuses before anything else is asked or moved.
    """

    def __init__(
        self,
        configuration: Configuration,
        devices: Actuators,
        capture: Capture,
        store: Store,
        *,
        clock: Clock = SYSTEM_CLOCK,
        analyse: Callable[[str], None] = leave_unanalysed,
        spawn: Callable[[Callable[[], None]], None] = in_thread,
        watches: Sequence[Watch] = (),
        permit: Permit | None = None,
    ) -> None:
        self._bench = Bench(configuration, devices, capture, store, clock)
        self._configuration, self._devices, self._store = configuration, devices, store
        self._clock, self._analyse = clock, analyse
        self._longest_run_s = longest_run_s(configuration.camera)
        self._stop = EmergencyStop(
            devices.cut_off,
            store.path,
            clock,
            afterwards=self._after_stop,
            witness=devices.trigger.powered if isinstance(devices.trigger, PowerQuery) else None,
            watches=watches,
            tripped=lambda why: self.estop("dead man", why),
        )
        self._clean_end = CleanEnd(store.path)
        self._permit = permit or NoPermitNeeded()
        self._conditions = Conditions(self._bench, self._stop, self._permit)
        self._standing = Standing(configuration, store, clock)
        self._running = RunningShot(self._standing, store, self._stop, clock)
        self._readiness = Readiness(self._standing, configuration.limits, clock)
        self._taking = Taking(
            self._bench,
            self._standing,
            self._readiness,
            conditions=self._conditions,
            running=self._running,
            run=ShotRun(self._bench, self._conditions, self._stop, self._running),
            spawn=spawn,
            analyse=analyse,
        )
        self._acting, self.listeners = threading.Lock(), self._standing.listeners

    def status(self) -> RigStatus:
        """Return where the rig stands, at once; a token whose time is over is withdrawn by it."""
        self._readiness.look_for_expired()
        status = self._standing.status()
        warnings = status.warnings + self._permit.warnings + self._stop.warnings
        return replace(status, warnings=warnings)

    def answers(self) -> bool:
        """Say within a bound whether the cut-off's thread takes orders."""
        return self._stop.answers()

    def arm(self, settings: ShotSettings, actor: str, *, still: bool = False) -> Armed:
        """Set pressure and offset, wait until they are reached, check everything, give a token.

        A token given before is dead from the first moment. Lost lines are opened again. Nothing
        moves unless the permit holds and the cut-off answers. The wait ends after the configured
        `settle_timeout_s`. With `still` nothing is set and nothing moves: everything is checked as
        it is.

        Raises
        ------
        SettingsError
            A setting lies outside the rig's limits; nothing moved.
        RefusedError
            The rig is in a state that does not arm, or somebody else is arming it.
        InterlockError
            Conditions refuse; all of them are named.
        DeviceError
            Regulator or slide did not take its command; the rig is in FAULT.
        StoreError
            The audit cannot be written.
        """
        require_within(settings, self._configuration.limits)
        with self._alone():
            self._await_safe_state()
            self._readiness.begin(settings, actor)
            reopen(self._devices, self._stop)
            self._require(self._conditions.permit(settings))
            if not still and self._conditions.cut_off().holds:
                try:
                    adjust(settings, self._bench, self._conditions, self._stop)
                except DeviceError as error:
                    self._fail(error)
                    raise
            conditions = self._conditions.all(settings)
            self._standing.found(conditions)
            self._require(conditions)
            armed = self._readiness.give(settings, actor)
            unmet = misses(settings, self._configuration)
            return replace(armed, warnings=(*armed.warnings, *unmet))

    def disarm(self, actor: str, reason: str) -> None:
        """Withdraw the live token, if there is one."""
        self._readiness.disarm(actor, reason)

    def rest(self) -> str:
        """Vent and stop the slide unless somebody uses the rig; say what became of each."""
        try:
            with self._alone():
                self._await_safe_state()
                return "; ".join(halt(self._devices)) if self.status().state == "idle" else ""
        except RefusedError:
            return ""

    def accept(
        self,
        token: str,
        key: str,
        body_hash: str,
        *,
        campaign: str | None = None,
        note: str | None = None,
        actor: str,
    ) -> ShotRecord:
        """Claim the key, spend the token, create the shot, start its run; return at once.

        A key that was used with the same body answers with its shot and fires nothing.

        Raises
        ------
        IdempotencyError
            The key is empty; or, as `KeyRunningError`, its shot has not ended; or, as
            `KeyReusedError`, it was used with another body.
        ArmTokenError
            The token does not hold; the key stays free.
        StoreError
            The claim is not on disk; nothing was fired, and the rig is disarmed.
        """
        return self._taking.accept(token, key, body_hash, campaign=campaign, note=note, actor=actor)

    def fire(
        self,
        token: str,
        key: str,
        body_hash: str,
        *,
        campaign: str | None = None,
        note: str | None = None,
        actor: str,
    ) -> ShotRecord:
        """As `accept`, then wait for the run's end; return the shot as it stands then.

        The camera's time-outs bound the wait; a record without `outcome` says that it was over.
        """
        shot = self.accept(token, key, body_hash, campaign=campaign, note=note, actor=actor)
        return self.wait(shot.id)

    def wait(self, shot: str, timeout_s: float | None = None) -> ShotRecord:
        """Wait until the rig has done with a shot, or the time is over; return it as it stands."""
        if self._running.name == shot:
            self._running.wait(self._longest_run_s if timeout_s is None else timeout_s)
        return self._store.shot(shot)

    def estop(self, actor: str, reason: str) -> None:
        """Cut the power of every actuator now; what the rig was doing follows.

        Open to everybody, at any time, from any thread. A shot whose fire command may be under
        way becomes `unknown_outcome`; one that is being recorded is still stored. After the cut
        slide, regulators and trigger are brought to rest, in a thread that nobody waits for.

        Raises
        ------
        DeviceError
            The cut-off did not confirm, or the trigger still reports power. The rig is latched all
            the same, and the status warns until a cut is confirmed.
        """
        try:
            self._stop.stop(actor, reason)
        finally:
            with self._standing.lock:
                self._readiness.stopped()
                self._running.overtake(f"emergency stop by {actor}: {reason}")
                self._standing.armed_for(self._standing.status().settings)
                self._standing.stopped(actor, reason, self._running.name)
                for warning in self._stop.warnings:
                    self._standing.note_of_stop(warning)

    def release(self, actor: str, reason: str) -> None:
        """Let a person end unknown_outcome, fault or estop; power comes back, the rig is idle.

        Lines that were lost are opened again first, and shots whose end could not be recorded are
        given one.

        Raises
        ------
        RefusedError
            No reason is given, nothing is to be released, a shot is still under way, or another
            stop came in meanwhile.
        StoreError
            A shot's end can still not be recorded; the latch stays.
        DeviceError
            Trigger or cut-off did not take its command; the latch stays.
        """
        if not reason.strip():
            raise RefusedError("a release needs a reason", todo="say what was found and done")
        with self._alone():
            self._require_releasable()
            closed = close_running(
                self._store, self._clock.wall(), "the store could not be written"
            )
            reopen(self._devices, self._stop)
            self._devices.trigger.make_safe()
            self._stop.restore()
            with self._standing.lock:
                if self._stop.latch is not None:
                    raise RefusedError("stopped again meanwhile", todo="release it once more")
                self._standing.move(RigState.IDLE, actor, reason, released=True)
        for shot in closed:
            if shot.state is ShotState.STORED:
                self._analyse(shot.id)

    def recover(self) -> Recovery:
        """Close what the last daemon left open and bring the devices to their safe state.

        Called once, before anything else. No shot is fired again. Power is given unless a person
        has to release the rig first: after a stop, and after an end that was not clean.

        Raises
        ------
        StoreError
            The store cannot be read or written.
        """
        with self._alone():
            recovery = start(
                self._store,
                self._standing,
                self._stop,
                self._devices.trigger,
                self._clock.wall(),
                clean=self._clean_end.take(),
            )
        for shot in recovery.to_analyse:
            self._analyse(shot)
        return recovery

    def close(self) -> None:
        """Disarm, let a shot end within its bounds, make the trigger safe, take the power.

        Power stays where a cut would let the spheres go. A rig that nobody has to release is
        marked as ended clean. Never raises; safe to call twice.
        """
        self.disarm(ACTOR, "the daemon ends")
        safe = self._running.wait(self._longest_run_s)
        try:
            self._devices.trigger.make_safe()
        except RigError:
            safe = False
            _log.exception("on closing the rig")
        self._stop.close(cut=self._configuration.trigger.power_cut == "holds")
        if safe and self._standing.state not in LATCHED and not self._stop.warnings:
            self._clean_end.leave()

    def _require(self, conditions: tuple[Interlock, ...]) -> None:
        try:
            require(conditions)
        except InterlockError as error:
            # No shot keeps it: nothing was ordered yet.
            _log.warning("arming was refused: %s", error)
            raise

    @contextmanager
    def _alone(self) -> Iterator[None]:
        if not self._acting.acquire(blocking=False):
            raise RefusedError(
                "the rig is being armed or released by somebody else", todo="try again in a moment"
            )
        try:
            yield
        finally:
            self._acting.release()

    def _await_safe_state(self) -> None:
        # Under the lock, or a row could be seen stored while the rig's state is still to follow.
        with self._standing.lock:
            ending = self._standing.state in _ENDING
        if ending:
            self._running.wait(_DEVICES_WAIT_S)

    def _after_stop(self) -> None:
        self._standing.note_of_stop("; ".join((*halt(self._devices), make_safe(self._devices))))

    def _fail(self, error: RigError) -> None:
        with self._standing.lock:
            if self._standing.state not in LATCHED:
                self._standing.move(RigState.FAULT, ACTOR, str(error))

    def _require_releasable(self) -> None:
        with self._standing.lock:
            if self._running.name is not None:
                raise RefusedError(
                    "a shot is still under way", todo="wait for its end", shot=self._running.name
                )
            if self._standing.state not in LATCHED:
                raise RefusedError(f"the rig is {self._standing.state}; nothing is to be released")
