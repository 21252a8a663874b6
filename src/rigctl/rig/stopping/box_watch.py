"""The trigger's own watch: a box that hears no heartbeat makes itself safe, with no host's help."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from rigctl.devices.roles import HeartbeatWatch
from rigctl.errors import DeviceError
from rigctl.rig.stopping.dead_man import BEAT_S, SILENT_S

_log = logging.getLogger(__name__)

MADE_SAFE = "the trigger box has made itself safe"
"""How the reason of a stop begins that the box has called for."""


class BoxWatch:
    """Has a trigger box watch over this process, and sends it heartbeats.

    Where the host as a whole hangs, no process of its own cuts any more; the box still disarms,
    and opens its contact in the power's line where one is wired.

    Parameters
    ----------
    box
        The trigger, on the line that it shares with the commands to fire.
    monotonic
        Time in s.
    """

    def __init__(
        self, box: HeartbeatWatch, monotonic: Callable[[], float] = time.monotonic
    ) -> None:
        self._box, self._monotonic = box, monotonic
        self._ended: threading.Event | None = None
        self._beating: threading.Thread | None = None

    @property
    def watches(self) -> bool:
        """Whether heartbeats are sent to a box that hears them."""
        return self._ended is not None and not self._ended.is_set()

    def start(self, alive: Callable[[], bool], tripped: Callable[[str], None]) -> None:
        """Begin to watch, unless it does already.

        A box of before the heartbeat is left as it is, and the log says so: what else watches is
        then all that watches.

        Parameters
        ----------
        alive
            Asked before each heartbeat; one that is not answered with True is left out.
        tripped
            Told once, with the reason, when the box has made itself safe, or must have.

        Raises
        ------
        DeviceError
            The box gives no answer, or refuses.
        """
        if self.watches:
            return
        if not self._box.watch(SILENT_S):
            _log.warning(
                "the trigger box is of a version without heartbeat: when the daemon dies, only the "
                "process that watches the relay cuts the power"
            )
            return
        self._ended = ended = threading.Event()
        self._beating = threading.Thread(
            target=self._beat, args=(ended, alive, tripped), name="box-heartbeat", daemon=True
        )
        self._beating.start()

    def end(self) -> None:
        """Watch no more; the box stays safe until the next start. Never raises a `DeviceError`."""
        ended, self._ended = self._ended, None
        if ended is None or ended.is_set():
            return
        ended.set()
        if self._beating is not None:
            self._beating.join(SILENT_S)
        try:
            self._box.end_watch()
        except DeviceError as error:
            _log.warning("the trigger box ends its watch by itself: %s", error)

    def _beat(
        self, ended: threading.Event, alive: Callable[[], bool], tripped: Callable[[str], None]
    ) -> None:
        heard_s = self._monotonic()
        while not ended.wait(BEAT_S):
            if not alive():
                continue
            try:
                why = None if self._box.beat() else "it says that no heartbeat came in time"
            except DeviceError as error:
                if self._monotonic() - heard_s < SILENT_S:
                    continue
                why = f"no heartbeat reached it for {SILENT_S:g} s: {error}"
            if why is not None:
                # Before anybody is told, or a release that follows would find it watching.
                ended.set()
                tripped(f"{MADE_SAFE}: {why}")
                return
            heard_s = self._monotonic()
