"""The watch of the trigger box: it is late when no heartbeat has come for a set time."""

from __future__ import annotations

from collections.abc import Callable

PERIOD_MS = (100, 10_000)


class Watch:
    """Times the heartbeats of a host, as `WATCH` and `BEAT` of the wire protocol say.

    States: none --WATCH--> kept --silence--> late --WATCH--> kept; `WATCH 0` leads to none. Its
    caller holds a lock.

    Parameters
    ----------
    clock
        Laboratory time in seconds.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._period_ms = 0
        self._due_s = 0.0
        self._late_since_s: float | None = None

    @property
    def is_kept(self) -> bool:
        """Whether a watch was set and is not late; the contact in the power's line is closed."""
        return self._period_ms > 0 and self.late_since_s is None

    @property
    def late_since_s(self) -> float | None:
        """When the heartbeats came too late; None where no watch is set, or it is kept."""
        if self._period_ms and self._late_since_s is None and self._clock() >= self._due_s:
            self._late_since_s = self._due_s
        return self._late_since_s

    @property
    def period_ms(self) -> int:
        """Longest silence in ms; 0: no watch is set."""
        return self._period_ms

    def set(self, period_ms: int) -> str:
        """Obey `WATCH`; return the answer."""
        if period_ms and not PERIOD_MS[0] <= period_ms <= PERIOD_MS[1]:
            return f"ERR RANGE period 0 or {PERIOD_MS[0]} to {PERIOD_MS[1]} ms"
        self._period_ms, self._late_since_s = period_ms, None
        self._due_s = self._clock() + period_ms * 1e-3
        return f"WATCHING {period_ms}"

    def beat(self) -> str:
        """Obey `BEAT`; return the answer."""
        if not self._period_ms:
            return "ERR NOWATCH none is set"
        if self.late_since_s is not None:
            return f"ERR LATE {self._period_ms}"
        self._due_s = self._clock() + self._period_ms * 1e-3
        return "BEAT"
