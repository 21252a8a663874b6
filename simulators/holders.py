"""Solenoids or a magnet that hold spheres: what switching their board and their supply lets go."""

from __future__ import annotations

import threading
from collections.abc import Callable

from simulators.world.release import Release

COMMAND_S = 4 * 10 / 9600
"""Time of one command of the board on its line: of two that arrive together, the second switches
so much later."""
TOGETHER_S = 0.12
"""A second sphere that goes within this belongs to the shot of the first: no delay is longer."""


class Holders:
    """One or two spheres, each held by the contact of its channel.

    A holder whose level holds gets a sphere at once: somebody has loaded it. When both have let
    go, or `TOGETHER_S` after one has, the release goes to the world.

    Parameters
    ----------
    channels
        1, or 1 and 2.
    holds_energised
        Whether current holds; otherwise a spring does, and current lets go.
    clock
        Laboratory time in seconds.
    release
        Takes what was let go.
    """

    def __init__(
        self,
        channels: tuple[int, ...],
        *,
        holds_energised: bool,
        clock: Callable[[], float],
        release: Callable[[Release], object],
    ) -> None:
        self._holds_energised, self._clock, self._release = holds_energised, clock, release
        self._on = dict.fromkeys(channels, False)
        # Without power, a spring holds what was loaded; current cannot.
        self._loaded = dict.fromkeys(channels, not holds_energised)
        self._gone: dict[int, float] = {}
        self._powered = False
        self._last_command_s = -COMMAND_S
        self._lock = threading.Lock()
        self._late: threading.Timer | None = None

    def switch(self, channel: int, on: bool) -> None:
        """Switch the contact of a channel; one that holds nothing is nobody's."""
        with self._lock:
            if channel not in self._on:
                return
            time_s = max(self._clock(), self._last_command_s + COMMAND_S)
            self._last_command_s = time_s
            self._on[channel] = on
            self._settle(channel, time_s)

    def power(self, on: bool) -> None:
        """Give or take the supply of all holders at once."""
        with self._lock:
            self._powered = on
            time_s = self._clock()
            for channel in self._on:
                self._settle(channel, time_s)

    def close(self) -> None:
        """Forget what is under way. Safe to call twice."""
        with self._lock:
            if self._late is not None:
                self._late.cancel()

    def _settle(self, channel: int, time_s: float) -> None:
        holds = (self._powered and self._on[channel]) == self._holds_energised
        if holds:
            self._loaded[channel] = True
        elif self._loaded[channel]:
            self._loaded[channel] = False
            self._let_go(channel, time_s)

    def _let_go(self, channel: int, time_s: float) -> None:
        if channel in self._gone:
            self._hand_over()
        self._gone[channel] = time_s
        if len(self._gone) == len(self._on):
            self._hand_over()
        else:
            self._late = threading.Timer(TOGETHER_S, self._alone)
            self._late.daemon = True
            self._late.start()

    def _alone(self) -> None:
        with self._lock:
            if self._gone:
                self._hand_over()

    def _hand_over(self) -> None:
        if self._late is not None:
            self._late.cancel()
        gone, self._gone = self._gone, {}
        self._release(Release(gone.get(1), gone.get(2)))
