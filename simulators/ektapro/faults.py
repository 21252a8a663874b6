"""Faults of the recorder's pictures, on command."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from simulators.wire.faults import require_count


class FrameFault(StrEnum):
    """What can go wrong between tape and capture folder.

    `missing-frames` says so in the JSON; `short-stack` does not. `extra-frame` repeats one
    picture with its number. `frozen` shows the first picture throughout. `wrong-size` halves the
    columns. `no-frames` answers the transfer and writes nothing.
    """

    MISSING_FRAMES = "missing-frames"
    SHORT_STACK = "short-stack"
    EXTRA_FRAME = "extra-frame"
    FROZEN = "frozen"
    WRONG_SIZE = "wrong-size"
    TRUNCATED_TIFF = "truncated-tiff"
    NO_FRAMES = "no-frames"


@dataclass(frozen=True, slots=True, eq=False)
class Stack:
    """Digitised pictures, shape (frames, rows, columns), with the number and time of each.

    `times_s` count from the session's first picture; `lost` are the numbers left out.
    """

    pixels: NDArray[np.uint8]
    frame_rate_hz: float
    sequence: list[int]
    times_s: list[float]
    lost: list[int]


@dataclass(slots=True)
class _Setting:
    kind: FrameFault
    times: int | None
    frames: int


@dataclass(frozen=True, slots=True)
class Struck:
    """A fault that strikes one transfer, and how many pictures it concerns."""

    kind: FrameFault
    frames: int


class FrameFaults:
    """The faults of the transfers to come. Any thread may set, clear and take."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._settings: list[_Setting] = []

    def set(self, kind: str, *, times: int | None = None, frames: int = 1) -> None:
        """Add a fault.

        Parameters
        ----------
        kind
            One of `FrameFault`.
        times
            How many transfers it strikes; None: every one until cleared.
        frames
            How many pictures are missing or repeated.

        Raises
        ------
        ValueError
            An unknown kind, or a number that cannot be.
        """
        if kind not in set(FrameFault):
            raise ValueError(f"fault {kind!r} is none of {', '.join(FrameFault)}")
        require_count("times", times)
        require_count("frames", frames)
        with self._lock:
            self._settings.append(_Setting(FrameFault(kind), times, frames))

    def clear(self) -> None:
        """Remove every fault."""
        with self._lock:
            self._settings.clear()

    def take(self) -> Struck | None:
        """Return the fault that strikes this transfer, and count it."""
        with self._lock:
            if not self._settings:
                return None
            setting = self._settings[0]
            if setting.times is not None:
                setting.times -= 1
                if setting.times == 0:
                    self._settings.pop(0)
            return Struck(setting.kind, setting.frames)


def spoil(stack: Stack, fault: Struck | None) -> Stack:
    """Return the stack as a fault leaves it; a single picture is left alone."""
    if fault is None or fault.kind not in _SPOILED or len(stack.sequence) < 2:
        return stack
    middle = len(stack.sequence) // 2
    return _SPOILED[fault.kind](stack, range(middle, middle + fault.frames))


def _without(stack: Stack, gone: range) -> Stack:
    kept = [place for place in range(len(stack.sequence)) if place not in gone]
    lost = [n for place, n in enumerate(stack.sequence) if place in gone]
    return replace(_picked(stack, kept), lost=lost)


def _shortened(stack: Stack, gone: range) -> Stack:
    return replace(stack, pixels=_without(stack, gone).pixels)


def _repeating(stack: Stack, again: range) -> Stack:
    head, tail = range(again.start), range(again.start, len(stack.sequence))
    return _picked(stack, [*head, *[again.start] * len(again), *tail])


def _frozen(stack: Stack, _places: range) -> Stack:
    return replace(stack, pixels=np.repeat(stack.pixels[:1], len(stack.pixels), axis=0))


def _halved(stack: Stack, _places: range) -> Stack:
    return replace(stack, pixels=stack.pixels[:, :, : stack.pixels.shape[2] // 2])


def _picked(stack: Stack, places: list[int]) -> Stack:
    return replace(
        stack,
        pixels=stack.pixels[places],
        sequence=[stack.sequence[place] for place in places],
        times_s=[stack.times_s[place] for place in places],
    )


_SPOILED: dict[FrameFault, Callable[[Stack, range], Stack]] = {
    FrameFault.MISSING_FRAMES: _without,
    FrameFault.SHORT_STACK: _shortened,
    FrameFault.EXTRA_FRAME: _repeating,
    FrameFault.FROZEN: _frozen,
    FrameFault.WRONG_SIZE: _halved,
}
