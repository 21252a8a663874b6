"""The emergency stop: a line of its own, cut before anything else is asked."""

from __future__ import annotations

import json
import logging
import threading
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from queue import SimpleQueue

from rigctl.devices.roles import CutOff
from rigctl.errors import DeviceError, DeviceSilentError, RefusedError, RigError
from rigctl.rig.clock import Clock
from rigctl.store.durable import sync_folder, write_synced

_log = logging.getLogger(__name__)

CUT_ATTEMPTS = 3
"""A cut is harmless when repeated, so it is the one act that may be."""

LINE_WAIT_S = 2.0
"""Longest wait for the cut-off's line. The cut goes on after it; only the caller is let go."""


@dataclass(frozen=True, slots=True)
class Latch:
    """Why the rig is stopped: who stopped it, why, and when (UTC, ISO 8601)."""

    actor: str
    reason: str
    at: str


@dataclass(slots=True)
class _Request:
    act: Callable[[], None]
    done: threading.Event = field(default_factory=threading.Event)
    error: RigError | None = None


class EmergencyStop:
    """Owner of the cut-off device, with a thread for its line alone.

    `stop` takes no lock of the rig and waits for no other device. The latch outlives the process:
    it is a file beside the catalogue, so a full or locked catalogue cannot lose it.

    Parameters
    ----------
    cut_off
        The device that takes the actuators' power.
    latch_file
        Where the latch is kept. A file that cannot be read counts as latched.
    afterwards
        What is tried once the power is cut, in a thread that nobody waits for.
    """

    def __init__(
        self, cut_off: CutOff, latch_file: Path, afterwards: Callable[[], None], clock: Clock
    ) -> None:
        self._cut_off, self._file, self._clock = cut_off, latch_file, clock
        self._afterwards = afterwards
        self._lock = threading.Lock()
        self._stops = 0
        self._powered = False
        self._latch = _read(latch_file)
        self._requests: SimpleQueue[_Request | None] = SimpleQueue()
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

    def stop(self, actor: str, reason: str) -> None:
        """Cut the power, then latch; callable from any thread, any number of times.

        The first latch is kept when several stops follow one another.

        Raises
        ------
        DeviceError
            The cut was not confirmed by its driver in time. The rig is latched all the same.
        """
        request = _Request(self._cut)
        self._requests.put(request)
        with self._lock:
            self._stops += 1
            self._powered = False
            latch = self._latch or Latch(actor, reason, self._clock.wall().isoformat())
            self._latch = latch
            self._keep(latch)
        self._await(request, "could not be cut", "switch the actuators off by hand")

    def restore(self) -> None:
        """Give power back and leave the latch.

        Raises
        ------
        RefusedError
            Another stop came in meanwhile: it holds.
        DeviceError
            The device did not take the command; the latch stays.
        """
        seen = self._stops
        request = _Request(lambda: self._restore(seen))
        self._requests.put(request)
        self._await(request, "could not be restored", "check the cut-off, then release again")

    def close(self) -> None:
        """End the thread; the cut-off stays as it is. Safe to call twice."""
        self._requests.put(None)
        self._thread.join(LINE_WAIT_S)

    def _serve(self) -> None:
        while (request := self._requests.get()) is not None:
            try:
                request.act()
            except RigError as error:
                request.error = error
            except Exception as error:  # noqa: BLE001 - this thread must outlive any driver
                request.error = DeviceError(repr(error), part=self._cut_off.name)
            request.done.set()

    def _cut(self) -> None:
        try:
            self._cut_repeatedly()
        finally:
            threading.Thread(target=self._follow_up, name="after-stop", daemon=True).start()

    def _cut_repeatedly(self) -> None:
        for attempt in range(1, CUT_ATTEMPTS + 1):
            try:
                return self._cut_off.cut()
            except Exception:
                _log.exception("cut-off, attempt %d of %d", attempt, CUT_ATTEMPTS)
                if attempt == CUT_ATTEMPTS:
                    raise
        return None

    def _follow_up(self) -> None:
        try:
            self._afterwards()
        except Exception:  # noqa: BLE001 - nobody waits for this, and the cut has been made
            _log.exception("after the emergency stop")

    def _restore(self, seen: int) -> None:
        if self._stops != seen:
            raise self._stopped_again()
        self._cut_off.restore()
        with self._lock:
            if self._stops != seen:
                raise self._stopped_again()
            self._forget()
            self._latch, self._powered = None, True

    def _stopped_again(self) -> RefusedError:
        return RefusedError("the rig was stopped again meanwhile", todo="release it once more")

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

    def _keep(self, latch: Latch) -> None:
        partial = self._file.with_suffix(".partial")
        try:
            partial.unlink(missing_ok=True)
            write_synced(partial, lambda file: file.write(json.dumps(asdict(latch)).encode()))
            partial.replace(self._file)
            sync_folder(self._file.parent)
        except OSError:
            _log.exception("the latch holds in memory only")

    def _forget(self) -> None:
        try:
            self._file.unlink(missing_ok=True)
            sync_folder(self._file.parent)
        except OSError as error:
            raise RefusedError(
                f"the latch file cannot be removed: {error.strerror}",
                part=str(self._file),
                todo="correct the folder's rights, then release again",
            ) from error


def _read(file: Path) -> Latch | None:
    try:
        return Latch(**json.loads(file.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return None
    except (OSError, ValueError, TypeError) as error:
        return Latch("rig", f"the latch file cannot be read: {error}", "")
