"""The shot in progress: its row and the rig's state, always moved together."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from rigctl.errors import RefusedError, RigError, StoreError
from rigctl.rig.clock import Clock
from rigctl.rig.standing import Standing
from rigctl.rig.states import Fired, RigState, ShotState
from rigctl.rig.stopping.estop import EmergencyStop
from rigctl.store.catalogue import Change
from rigctl.store.records import ShotRecord
from rigctl.store.store import Store

_log = logging.getLogger(__name__)

ACTOR = "rig"
"""How the rig calls itself in the audit."""

_OPEN = frozenset({RigState.FIRING, RigState.CAPTURING})
_ENDED = frozenset({RigState.STORED, RigState.ABORTED, RigState.MISFIRE})


def in_thread(work: Callable[[], None]) -> None:
    """Run a shot's work in a thread of its own."""
    threading.Thread(target=work, name="shot", daemon=True).start()


def leave_unanalysed(_shot: str) -> None:
    """Without an analyser a stored shot waits for the next start."""


class RunningShot:
    """Implements `firing.Progress`; every method takes the rig's lock for one step."""

    def __init__(self, standing: Standing, store: Store, stop: EmergencyStop, clock: Clock) -> None:
        self._standing, self._store, self._stop, self._clock = standing, store, stop, clock
        self._shot: ShotRecord | None = None
        self._at_rest = threading.Event()
        self._at_rest.set()

    @property
    def name(self) -> str | None:
        """The shot in progress, until its safe state is reached."""
        return self._standing.status().running

    def wait(self, timeout_s: float) -> bool:
        """Wait until no shot is in progress; return whether that is so."""
        return self._at_rest.wait(timeout_s)

    def begin(self, shot: ShotRecord) -> None:
        """Take up an accepted shot. The caller holds the rig's lock."""
        self._shot = shot
        self._standing.runs(shot.id)
        self._at_rest.clear()

    def intend(self, shot: ShotRecord) -> ShotRecord:
        """Put the intent on disk; as `firing.Progress.intend`."""
        with self._standing.lock:
            if self._standing.state is not RigState.FIRING or self._stop.latch is not None:
                raise RefusedError("stopped before the fire command left", shot=shot.id)
            intent = Change(fired=Fired.UNKNOWN)
            self._shot = self._store.move(shot.id, ShotState.FIRING, intent)
            return self._shot

    def confirm(self, shot: ShotRecord, change: Change) -> ShotRecord | None:
        """Put the confirmed fire on disk; as `firing.Progress.confirm`."""
        with self._standing.lock:
            if self._stop.latch is not None:
                # The pulses may have met the cut: the trigger's word is no longer enough.
                why = "stopped while the fire command was under way"
                self.overtake(why)
                if self._standing.state is RigState.FIRING:
                    self._standing.move(RigState.UNKNOWN_OUTCOME, ACTOR, why, shot.id)
                return None
            self._shot = self._store.move(shot.id, ShotState.CAPTURING, change)
            reason = "the trigger confirmed the fire"
            self._standing.move(RigState.CAPTURING, ACTOR, reason, shot.id)
            return self._shot

    def end(self, shot: ShotRecord, state: ShotState, change: Change) -> StoreError | None:
        """Leave the shot in a final state; as `firing.Progress.end`."""
        with self._standing.lock:
            unstored = self._close(shot, state, change)
            if self._standing.state in _OPEN:
                after = RigState(state)
                if unstored is not None and after is RigState.STORED:
                    after = RigState.ABORTED
                reason = change.failure or "all frames are on disk"
                self._standing.move(after, ACTOR, reason, shot.id)
            return unstored

    def overtake(self, why: str) -> None:
        """Call a shot whose fire command may be under way unknown. The caller holds the lock."""
        shot = self._shot
        if shot is None or shot.state is not ShotState.FIRING:
            return
        change = Change(
            fired=Fired.UNKNOWN,
            ended_at=self._clock.wall(),
            failure=why,
            failure_code=RefusedError.code,
        )
        self._close(shot, ShotState.UNKNOWN_OUTCOME, change)

    def finish(self, failure: RigError | None) -> ShotRecord | None:
        """Leave the shot behind once the devices are safe: the rig is idle, or in FAULT."""
        with self._standing.lock:
            record = self._shot
            shot = None if record is None else record.id
            # Only a program that is being torn down leaves a shot open here.
            if self._standing.state is RigState.FIRING:
                why = "the run of the shot was torn down"
                self._standing.move(RigState.UNKNOWN_OUTCOME, ACTOR, why, shot)
            elif self._standing.state is RigState.CAPTURING:
                self._standing.move(RigState.ABORTED, ACTOR, "torn down", shot)
            if self._standing.state in _ENDED:
                after = RigState.IDLE if failure is None else RigState.FAULT
                reason = "safe state reached" if failure is None else str(failure)
                self._standing.move(after, ACTOR, reason, shot)
            elif failure is not None:
                _log.error("shot %s: %s", shot, failure)
            self._shot = None
            self._standing.runs(None)
            self._at_rest.set()
            return record

    def _close(self, shot: ShotRecord, state: ShotState, change: Change) -> StoreError | None:
        if self._shot is not None and self._shot.outcome is not None:
            return None
        try:
            self._shot = self._store.move(shot.id, state, change)
        except StoreError as error:
            _log.exception("shot %s: its state %s is not on disk", shot.id, state)
            return error
        return None
