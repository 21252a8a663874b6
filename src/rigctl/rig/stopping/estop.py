"""The emergency stop: a line of its own, cut before anything else is asked."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from queue import SimpleQueue

from rigctl.devices.roles import CutOff
from rigctl.errors import DeviceError, DeviceSilentError, RefusedError, RigError
from rigctl.rig.clock import Clock
from rigctl.rig.stopping.dead_man import SILENT_S
from rigctl.rig.stopping.latch import KEEP_AGAIN_S, Latch, LatchFile
from rigctl.rig.stopping.watch import Watch
from rigctl.rig.stopping.witness import Sight, Witness, look

_log = logging.getLogger(__name__)

CUT_ATTEMPTS = 3
"""A cut is harmless when repeated, so it is the one act that may be."""

RETRY_S = 0.2
"""Pause before a cut is tried again: a board that was plugged in needs a moment, s."""

LINE_WAIT_S = 2.0
"""Longest wait for the cut-off's line. The cut goes on after it; only the caller is let go."""

REST_WAIT_S = 2.0
"""Longest wait of a release for each device that the last stop still brings to rest, s."""

WITNESS_WAIT_S = 1.0
"""Longest wait of a caller for the trigger's word that the power is off, s."""

_UNDER_WAY = "the cut is under way"
_BY_HAND = "switch the actuators off by hand"


@dataclass(slots=True)
class _Request:
    """One act for the cut-off's thread: what became of it, and what was seen of it."""

    act: Callable[[_Request], None]
    latched: threading.Event = field(default_factory=threading.Event)
    done: threading.Event = field(default_factory=threading.Event)
    error: RigError | None = None
    looked: threading.Event = field(default_factory=threading.Event)
    sight: Sight | None = None


class EmergencyStop:
    """Owner of the cut-off device, with a thread for its line alone.

    `stop` takes no lock of the rig and waits for no other device before the cut. Each cut opens
    the line again if it was lost.

    Parameters
    ----------
    cut_off
        The device that takes the actuators' power.
    folder
        Where the reason of the latch is kept; see `LatchFile`.
    clock
        Time.
    afterwards
        What is tried once the power is cut, in a thread that nobody waits for.
    witness
        Another device's word on whether the actuators have power; None where none can tell, and
        a cut that left the host is then all that is known.
    watches
        Act when this process no longer can; power is never given without them. None where a cut
        lets spheres go, or where nothing outlives this process.
    tripped
        Told the reason when one of them has acted, or ended by itself.
    """

    def __init__(
        self,
        cut_off: CutOff,
        folder: Path,
        clock: Clock,
        *,
        afterwards: Callable[[], None],
        witness: Witness | None,
        watches: Sequence[Watch] = (),
        tripped: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._cut_off, self._file, self._clock = cut_off, LatchFile(folder), clock
        self._afterwards, self._witness = afterwards, witness
        self._watches, self._tripped = tuple(watches), tripped
        self._lock = threading.Lock()
        # Guards what is known of the power; never held while a disk or a device is waited for.
        self._known = threading.Lock()
        self._stops = self._orders = self._rests = 0
        self._waiting: _Request | None = None
        self._powered = False
        self._doubt: str | None = None
        self._latch = self._file.read()
        self._requests: SimpleQueue[_Request | None] = SimpleQueue()
        self._followers: list[threading.Thread] = []
        self._thread = threading.Thread(target=self._serve, name="cut-off", daemon=True)
        self._thread.start()

    @property
    def latch(self) -> Latch | None:
        """The latch, or None when nothing is stopped."""
        return self._latch

    @property
    def powered(self) -> bool:
        """Whether the cut-off was told to give power, and has not been told to cut since."""
        return self._powered

    @property
    def warnings(self) -> tuple[str, ...]:
        """Say what is not as it should be after a stop: the power, or the record of its reason."""
        doubt, unkept = self._doubt, self._file.unkept
        said = []
        if doubt is not None:
            said.append(f"the power is NOT confirmed off: {doubt}; {_BY_HAND}")
        if unkept is not None:
            said.append(
                f"the stop holds and outlasts a restart, but its reason is not on disk ({unkept}); "
                f"it is written again every {KEEP_AGAIN_S:g} s: make room on the disk"
            )
        return tuple(said)

    def answers(self) -> bool:
        """Say whether the cut-off's thread takes orders: a daemon that cannot stop is none."""
        request = _Request(lambda _: None)
        self._requests.put(request)
        return request.done.wait(SILENT_S)

    def check(self) -> None:
        """Ask the cut-off for its sign of life; opens nothing.

        Raises
        ------
        DeviceError
            There is none, or none within `LINE_WAIT_S`.
        """
        self._in_turn(self._cut_off.check)

    def reopen(self) -> None:
        """See whether the cut-off's line is there, and open it again if it was lost.

        Raises
        ------
        DeviceError
            It cannot be opened.
        """
        self._in_turn(self._cut_off.reopen)

    def stop(self, actor: str, reason: str) -> None:
        """Cut the power, then latch; callable from any thread, any number of times.

        The first latch is kept when several stops follow one another.

        Raises
        ------
        DeviceError
            The cut was not confirmed by its driver in time, or the witness still sees power. The
            rig is latched all the same, and `warnings` says what is known.
        """
        request = self._order_stop()
        with self._lock:
            self._stops += 1
            self._powered = False
            latch = self._latch or Latch(actor, reason, self._clock.wall().isoformat())
            self._latch = latch
            request.latched.set()
            self._file.keep(latch)
        self._await_cut(request)

    def restore(self) -> None:
        """Give power back and leave the latch; wait a moment until the witness sees it.

        Power that does not come is for the interlocks to name.

        Raises
        ------
        RefusedError
            Another stop came in meanwhile: it holds. Or the last one has not done yet: what it
            brings to rest must not be moved meanwhile.
        DeviceError
            The device did not take the command; the latch stays, and the power is cut again.
        """
        seen = self._stops
        self._await_followers()
        for watch in self._watches:
            watch.start(self.answers, self._tripped)
        request = _Request(lambda _: self._restore(seen))
        self._requests.put(request)
        self._await(request, "could not be restored", "check the cut-off, then release again")
        if self._witness is not None:
            doubt = look(self._witness, self._clock, wanted=True).doubt
            if doubt is not None:
                _log.warning("after the power was given: %s", doubt)

    def close(self, *, cut: bool = False) -> None:
        """End the threads, after a last cut without a latch where one is wanted.

        Never raises a `RigError`; safe to call twice.
        """
        if cut and self._thread.is_alive():
            try:
                self._await_cut(self._order_cut(self._take_power))
            except RigError:
                _log.exception("on closing the cut-off")
        self._file.close()
        for watch in self._watches:
            watch.end()
        self._requests.put(None)
        self._thread.join(LINE_WAIT_S)
        self._await_followers()

    def _serve(self) -> None:
        while (request := self._requests.get()) is not None:
            try:
                request.act(request)
            except RigError as error:
                request.error = error
            except Exception as error:  # noqa: BLE001 - this thread must outlive any driver
                request.error = DeviceError(repr(error), part=self._cut_off.name)
            request.done.set()

    def _order_stop(self) -> _Request:
        """Order a cut, or share one that is ordered and has not begun."""
        with self._known:
            self._powered, self._doubt = False, _UNDER_WAY
            shared = self._waiting
            if shared is not None:
                return shared
            self._waiting = request = _Request(self._stop_all)
        self._requests.put(request)
        return request

    def _order_cut(self, act: Callable[[_Request], None]) -> _Request:
        request = _Request(act)
        # Before the cut, or a cut that is quick to be confirmed would be doubted for ever.
        with self._known:
            self._powered, self._doubt = False, _UNDER_WAY
        self._requests.put(request)
        return request

    def _stop_all(self, request: _Request) -> None:
        with self._known:
            self._waiting = None
        try:
            self._take_power(request)
        finally:
            self._rest(request)

    def _take_power(self, request: _Request) -> None:
        failure: str | None = None
        with self._known:
            self._orders += 1
            order = self._orders
            self._powered, self._doubt = False, _UNDER_WAY
        try:
            self._cut_repeatedly()
        except Exception as error:
            failure = f"the cut failed ({error})"
            raise
        finally:
            witness = self._witness
            if witness is None:
                self._saw(order, request, Sight(None, failure))
            else:
                self._learn(order, failure or "the trigger has not yet said that its power is off")
                self._follow("cut-witness", lambda: self._look(witness, order, request, failure))

    def _cut_repeatedly(self) -> None:
        for attempt in range(1, CUT_ATTEMPTS + 1):
            try:
                return self._cut_off.cut()
            except Exception:
                _log.exception("cut-off, attempt %d of %d", attempt, CUT_ATTEMPTS)
                if attempt == CUT_ATTEMPTS:
                    raise
            self._clock.wait(RETRY_S)
        return None

    def _look(self, witness: Witness, order: int, request: _Request, failure: str | None) -> None:
        sight = look(witness, self._clock, wanted=False)
        if sight.doubt is not None and failure is not None:
            sight = Sight(sight.powered, f"{failure}; {sight.doubt}")
        self._saw(order, request, sight)

    def _saw(self, order: int, request: _Request, sight: Sight) -> None:
        self._learn(order, sight.doubt)
        request.sight = sight
        request.looked.set()

    def _learn(self, order: int, doubt: str | None) -> None:
        with self._known:
            if order == self._orders:
                self._doubt = doubt

    def _follow(self, name: str, work: Callable[[], None]) -> None:
        self._followers = [thread for thread in self._followers if thread.is_alive()]
        thread = threading.Thread(target=work, name=name, daemon=True)
        self._followers.append(thread)
        thread.start()

    def _await_followers(self) -> None:
        for thread in self._followers:
            thread.join(REST_WAIT_S)

    def _rest(self, request: _Request) -> None:
        """Have the devices brought to rest; where that is under way, once more after it."""
        with self._known:
            self._rests = min(self._rests + 1, 2)
            under_way = self._rests == 2
        if not under_way:
            self._follow("after-stop", lambda: self._rest_all(request))

    def _rest_all(self, request: _Request) -> None:
        # Whoever moves something looks at the latch afterwards; so it must be set before this.
        request.latched.wait(LINE_WAIT_S)
        again = True
        while again:
            try:
                self._afterwards()
            except Exception:  # noqa: BLE001 - nobody waits for this, and the cut has been made
                _log.exception("after the emergency stop")
            with self._known:
                self._rests -= 1
                again = self._rests > 0

    def _restore(self, seen: int) -> None:
        if self._stops != seen:
            raise self._stopped_again()
        if any(thread.is_alive() for thread in self._followers):
            raise RefusedError(
                "the last stop is still bringing the devices to rest",
                todo="release it again in a moment",
            )
        self._cut_off.reopen()
        try:
            with self._known:
                self._orders += 1
            self._cut_off.restore()
            with self._lock:
                if self._stops != seen:
                    raise self._stopped_again()
                self._file.forget()
                with self._known:
                    self._latch, self._powered, self._doubt = None, True, None
        except Exception:
            self._cut_after_failed_restore()
            raise

    def _cut_after_failed_restore(self) -> None:
        try:
            self._take_power(_Request(self._take_power))
        except Exception:  # noqa: BLE001 - the failure of the restore is what the caller is told
            _log.exception("the power was not cut again after a restore that failed")

    def _stopped_again(self) -> RefusedError:
        return RefusedError("the rig was stopped again meanwhile", todo="release it once more")

    def _in_turn(self, act: Callable[[], None]) -> None:
        request = _Request(lambda _: act())
        self._requests.put(request)
        if not request.done.wait(LINE_WAIT_S):
            raise DeviceSilentError(
                "its line is not free",
                part=self._cut_off.name,
                limit=f"{LINE_WAIT_S:g} s",
                todo="check the cut-off's cable and power",
            )
        if request.error is not None:
            raise request.error

    def _await_cut(self, request: _Request) -> None:
        self._await(request, "could not be cut", _BY_HAND)
        if not request.looked.wait(WITNESS_WAIT_S):
            _log.warning("the trigger has not said in time whether its outputs have power")
        elif request.sight is not None and request.sight.powered:
            raise DeviceError(
                f"the power is NOT off after the cut: {request.sight.doubt}",
                part=self._cut_off.name,
                todo=_BY_HAND,
            )

    def _await(self, request: _Request, what: str, todo: str) -> None:
        if not request.done.wait(LINE_WAIT_S):
            raise DeviceSilentError(
                what, part=self._cut_off.name, limit=f"{LINE_WAIT_S:g} s", todo=todo
            )
        if isinstance(request.error, RefusedError):
            raise request.error
        if request.error is not None:
            raise DeviceError(
                f"{what}: {request.error}", part=self._cut_off.name, todo=todo
            ) from request.error
