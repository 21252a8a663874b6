"""Where the rig stands: one lock, one snapshot, one place of change; the audit has every change."""

from __future__ import annotations

import logging
import threading
from dataclasses import replace
from datetime import datetime

from rigctl.config import Configuration
from rigctl.errors import StoreError
from rigctl.listeners import Listeners
from rigctl.rig.clock import Clock
from rigctl.rig.interlocks import Interlock
from rigctl.rig.states import LATCHED, TOWARD_FIRE, RigState, require_move
from rigctl.rig.status import RigStatus, Transition
from rigctl.rig.stopping.latch import RepeatedStops
from rigctl.settings import ShotSettings
from rigctl.store.journal import Journal
from rigctl.store.records import ShotRecord
from rigctl.store.store import Store

_log = logging.getLogger(__name__)


class Logbook:
    """The rig's side of the audit. The rig's lock guards every call.

    A step toward firing is not taken unless it is on disk. A step toward safety is taken in any
    case; what the disk refuses of it is written later, in order, before anything else.
    """

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self._owed: list[Transition] = []

    def write(self, transition: Transition) -> None:
        """Append a transition.

        Raises
        ------
        StoreError
            The audit cannot be written and the step leads toward firing.
        """
        owed = [*self._owed, transition]
        try:
            while owed:
                self._append(owed[0])
                del owed[0]
        except StoreError:
            if transition.after in TOWARD_FIRE:
                self._owed = owed[:-1]
                raise
            _log.exception("transition to %s is owed to the audit", transition.after)
        self._owed = owed

    def _append(self, transition: Transition) -> None:
        self._journal.append(
            at=transition.at,
            before=transition.before,
            after=transition.after,
            actor=transition.actor,
            reason=transition.reason,
            shot=transition.shot,
        )


AFTER_STOP = "rig, after the stop"
"""Actor of the audit's notes on what became of a stop; they are no steps of the rig."""

NOTE_WAIT_S = 5.0
"""Longest wait of a note for the state that it belongs to, s."""

_RELEASES_ON_CUT = "a power cut or an emergency stop lets the spheres go: keep clear of the tubes"


class Standing:
    """State of the rig. Whoever changes it holds `lock`; whoever reads takes the snapshot.

    Attributes
    ----------
    lock
        Held for a transition and its line in the audit, never while a device is waited for.
    listeners
        Told of each transition after it has happened.
    """

    def __init__(self, configuration: Configuration, store: Store, clock: Clock) -> None:
        self.lock = threading.RLock()
        self._moved = threading.Condition(self.lock)
        self.listeners: Listeners[Transition] = Listeners()
        self._logbook, self._clock = Logbook(store.journal), clock
        self._repeated = RepeatedStops(clock.monotonic)
        self._noted: set[str] = set()
        trigger = configuration.trigger
        releases = trigger.power_cut == "fires"
        self._status = RigStatus(
            name=configuration.name,
            apparatus=configuration.apparatus,
            simulated=configuration.simulation is not None,
            state=RigState.IDLE,
            since=clock.wall(),
            reason="not recovered yet",
            settings=None,
            token_expires_at=None,
            token_ends_s=None,
            interlocks=(),
            read_at=clock.monotonic(),
            running=None,
            last_shot=None,
            latch_reason=None,
            warnings=(_RELEASES_ON_CUT,) if releases else (),
        )
        store.listeners.add(self._shot_changed)

    @property
    def state(self) -> RigState:
        """The present state; it may change at once unless the caller holds the lock."""
        return self._status.state

    def status(self) -> RigStatus:
        """Return the snapshot, without waiting for anybody."""
        return replace(self._status, read_at=self._clock.monotonic())

    def move(
        self,
        to: RigState,
        actor: str,
        reason: str,
        shot: str | None = None,
        *,
        released: bool = False,
    ) -> None:
        """Make a transition of the table; journal it, then take it, then tell it.

        Raises
        ------
        RefusedError
            The table does not hold it.
        StoreError
            It leads toward firing and the audit cannot be written; the state is unchanged.
        """
        with self.lock:
            require_move(self.state, to, released=released)
            if released and (counted := self._repeated.take_count()):
                reason = f"{reason} (stopped {counted} times more, which were not written)"
            self._take(to, actor, reason, shot)

    def stopped(self, actor: str, reason: str, shot: str | None) -> None:
        """Enter `estop`; of many stops in a row a few are journalled, the others counted."""
        with self.lock:
            if self.state is not RigState.ESTOP or self._repeated.is_written():
                self.move(RigState.ESTOP, actor, reason, shot)

    def start(
        self, before: RigState, to: RigState, reason: str, since: datetime | None = None
    ) -> None:
        """Enter the state in which the rig starts, whatever it was when the last daemon ended.

        `since` is when it came there, where that was before this start.
        """
        with self.lock:
            self._status = replace(self._status, state=before)
            self._take(to, "rig", reason, None)
            self._status = replace(self._status, since=since or self._status.since)

    def _take(self, to: RigState, actor: str, reason: str, shot: str | None) -> None:
        step = Transition(self.state, to, self._clock.wall(), actor, reason, shot)
        self._logbook.write(step)
        if to is not RigState.ESTOP:
            self._noted.clear()
        self._status = replace(
            self._status,
            state=to,
            since=step.at,
            reason=reason,
            latch_reason=reason if to in LATCHED else None,
        )
        self._moved.notify_all()
        self.listeners.notify(step)

    def note_of_stop(self, text: str) -> None:
        """Journal what became of an emergency stop, without changing the state or its reason.

        The same text again is not written once more until the rig has left the stop.

        Waits up to `NOTE_WAIT_S` for the rig to be stopped, so that the entry follows its cause; a
        rig that is not, or is no longer, leaves the text to the log.
        """
        stopped = RigState.ESTOP
        with self._moved:
            if not self._moved.wait_for(lambda: self.state is stopped, NOTE_WAIT_S):
                _log.warning("not journalled, the rig is %s: %s", self.state, text)
                return
            if text in self._noted:
                return
            self._noted.add(text)
            step = Transition(stopped, stopped, self._clock.wall(), AFTER_STOP, text, None)
            self._logbook.write(step)
            self.listeners.notify(step)

    def armed_for(
        self,
        settings: ShotSettings | None,
        expires_at: datetime | None = None,
        ends_s: float | None = None,
    ) -> None:
        """Show the settings last asked for and the end of their token, UTC and monotonic."""
        with self.lock:
            self._status = replace(
                self._status,
                settings=settings,
                token_expires_at=expires_at,
                token_ends_s=ends_s,
            )

    def found(self, conditions: tuple[Interlock, ...]) -> None:
        """Show the interlocks as last read."""
        with self.lock:
            self._status = replace(self._status, interlocks=conditions)

    def runs(self, shot: str | None) -> None:
        """Show the shot in progress."""
        with self.lock:
            self._status = replace(self._status, running=shot)

    def _shot_changed(self, shot: ShotRecord) -> None:
        with self.lock:
            last = self._status.last_shot
            if last is None or shot.number >= last.number:
                self._status = replace(self._status, last_shot=shot)

    def last_shot(self, shot: ShotRecord | None) -> None:
        """Show the shot that was last before the daemon started."""
        if shot is not None:
            self._shot_changed(shot)
