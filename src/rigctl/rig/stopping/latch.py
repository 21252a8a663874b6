"""What outlives the process: why the rig is stopped, and whether its last daemon ended clean.

And which of many stops are written one by one.
"""

from __future__ import annotations

import json
import logging
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from rigctl.errors import RefusedError, StoreError
from rigctl.store.durable import sync_folder, write_synced

_log = logging.getLogger(__name__)

KEEP_AGAIN_S = 1.0
"""Pause before a latch that the disk refused is written again, s."""

LATCH_FILE = "estop.json"
CLEAN_END_FILE = "clean-end"


@dataclass(frozen=True, slots=True)
class Latch:
    """Why the rig is stopped: who stopped it, why, and when (UTC, ISO 8601)."""

    actor: str
    reason: str
    at: str


class LatchFile:
    """The reason of a stop, in a file beside the catalogue.

    The latch itself does not depend on it: a stopped rig leaves no `CleanEnd`, and so starts
    latched, whatever became of this file.

    Parameters
    ----------
    folder
        Of the store.

    Attributes
    ----------
    unkept
        Why the present latch is not on disk; None where it is, or where there is none.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / LATCH_FILE
        self._lock, self._closed = threading.Lock(), threading.Event()
        self.unkept: str | None = None

    def read(self) -> Latch | None:
        """Return the latch; a file that cannot be read counts as one."""
        try:
            return Latch(**json.loads(self._path.read_text(encoding="utf-8")))
        except FileNotFoundError:
            return None
        except (OSError, ValueError, TypeError) as error:
            return Latch("rig", f"the latch file cannot be read: {error}", "")

    def keep(self, latch: Latch) -> None:
        """Force the latch to disk; where the disk refuses, try again until it does or `forget`.

        Never raises; `unkept` says what is in the way.
        """
        with self._lock:
            trying = self.unkept is not None
            self._write(latch)
            if self.unkept is None or trying:
                return
        threading.Thread(
            target=self._keep_again, args=(latch,), name="latch-file", daemon=True
        ).start()

    def forget(self) -> None:
        """Remove the file.

        Raises
        ------
        RefusedError
            The disk does not let it go, so a restart would find it again.
        """
        with self._lock:
            try:
                self._path.unlink(missing_ok=True)
                sync_folder(self._path.parent)
            except OSError as error:
                raise RefusedError(
                    f"the latch file cannot be removed: {error.strerror}",
                    part=str(self._path),
                    todo="correct the folder's rights, then release again",
                ) from error
            self.unkept = None

    def close(self) -> None:
        """Try no more."""
        self._closed.set()

    def _keep_again(self, latch: Latch) -> None:
        while not self._closed.wait(KEEP_AGAIN_S):
            with self._lock:
                if self.unkept is not None:
                    self._write(latch)
                if self.unkept is None:
                    return

    def _write(self, latch: Latch) -> None:
        partial = self._path.with_suffix(".partial")
        try:
            partial.unlink(missing_ok=True)
            write_synced(partial, lambda file: file.write(json.dumps(asdict(latch)).encode()))
            partial.replace(self._path)
            sync_folder(self._path.parent)
        except OSError as error:
            _log.warning("the reason of the stop is not on disk: %s", error)
            self.unkept = error.strerror or str(error)
        else:
            self.unkept = None


class CleanEnd:
    """A mark that the last daemon left behind when it ended unlatched, with the power cut.

    A daemon takes the mark away when it starts, and leaves one only where a start may give power.
    So a stop needs no disk to outlive the daemon: a full disk, a kill or a power failure leave no
    mark, and the next daemon starts latched.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / CLEAN_END_FILE

    def take(self) -> bool:
        """Take the mark away, on disk; return whether it was there.

        Raises
        ------
        StoreError
            The disk does not let it go: after a kill a start would give power.
        """
        try:
            self._path.unlink()
            sync_folder(self._path.parent)
        except FileNotFoundError:
            return False
        except OSError as error:
            raise StoreError(
                f"the mark of a clean end cannot be removed: {error.strerror}",
                part=str(self._path),
                todo="correct the folder's rights, then start again",
            ) from error
        return True

    def leave(self) -> None:
        """Leave the mark; where the disk refuses, the next start is latched. Never raises."""
        try:
            self._path.unlink(missing_ok=True)
            write_synced(self._path, lambda file: file.write(b"the last daemon ended clean\n"))
            sync_folder(self._path.parent)
        except OSError as error:
            _log.warning("the rig starts latched next time: %s", error)


MOST_STOPS = 5
STOPS_WITHIN_S = 10.0
"""Further stops of a stopped rig: so many within this time are written, the rest counted."""


class RepeatedStops:
    """Counts the stops that came after the first; the caller guards every call by one lock.

    Parameters
    ----------
    monotonic
        Time in s.
    """

    def __init__(self, monotonic: Callable[[], float]) -> None:
        self._monotonic = monotonic
        self._written: deque[float] = deque(maxlen=MOST_STOPS)
        self._counted = 0

    def is_written(self) -> bool:
        """Say whether this stop is written; it is counted where it is not."""
        now = self._monotonic()
        if len(self._written) == MOST_STOPS and now - self._written[0] < STOPS_WITHIN_S:
            self._counted += 1
            return False
        self._written.append(now)
        return True

    def take_count(self) -> int:
        """Return how many were counted and not written, and begin anew."""
        counted, self._counted = self._counted, 0
        return counted
