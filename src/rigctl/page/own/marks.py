"""Marks that a person drags on a picture of a film, and the scale that follows from them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from analysis.quantity import Quantity
from rigctl.documents import Json

Numbers = tuple[float, ...]

BY_EYE_PX = 1.0
"""Standard error of an end of a line, or of a ring's border, that is put there by eye."""
UNLIKE = 0.25
"""Share of a ring's diameter by which a measured ball is not the ringed one."""
APART = 3.0
"""Standard errors beyond which two scales contradict each other."""


@dataclass(frozen=True, slots=True)
class Marks:
    """Marks on a picture, in pixels from its upper left corner.

    Attributes
    ----------
    part
        Column, row, width and height of the part that is looked at; None: all of the picture.
    ring
        Column and row of the ball's centre, and its radius.
    line
        Columns and rows of both ends of a line over a known length.
    """

    part: Numbers | None = None
    ring: Numbers | None = None
    line: Numbers | None = None

    @classmethod
    def from_json(cls, given: Json, size: tuple[int, int]) -> Marks:
        """Read what a browser sends; a part that is all of the picture is none.

        Parameters
        ----------
        size
            Columns and rows of the picture.

        Raises
        ------
        ValueError
            A mark has not so many finite numbers as it needs.
        """
        part, ring, line = (
            _numbers(given.get(name), count)
            for name, count in (("part", 4), ("ring", 3), ("line", 4))
        )
        whole = part is None or window_of(part, size) == (0, 0, *size)
        return cls(None if whole else part, ring, line)

    @property
    def across_px(self) -> Quantity | None:
        """Diameter of the ring, as it is put by eye."""
        if self.ring is None:
            return None
        return Quantity(2 * self.ring[2], math.sqrt(2.0) * BY_EYE_PX, "px")

    @property
    def length_px(self) -> Quantity | None:
        """Length of the line, as it is put by eye."""
        if self.line is None:
            return None
        x0, y0, x1, y1 = self.line
        return Quantity(math.hypot(x1 - x0, y1 - y0), math.sqrt(2.0) * BY_EYE_PX, "px")

    def without_ring(self) -> Marks:
        """Return the same for another picture."""
        return replace(self, ring=None)


def window_of(part: Numbers, size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return a part in whole pixels within a picture of (columns, rows)."""
    left, top, width, height = part
    ends = [
        (max(0, round(start)), min(most, round(start + length)))
        for start, length, most in ((left, width, size[0]), (top, height, size[1]))
    ]
    (x0, x1), (y0, y1) = ends
    return x0, y0, x1 - x0, y1 - y0


def diameter_by_line(marks: Marks, length_mm: float | None) -> Quantity | None:
    """Return the ball's diameter in mm by a line over a known length; None where one is missing."""
    across, length = marks.across_px, marks.length_px
    if not length_mm or across is None or length is None or length.value <= 0:
        return None
    value = length_mm * across.value / length.value
    relative = math.hypot(across.sigma / across.value, length.sigma / length.value)
    return Quantity(value, value * relative, "mm")


def scale_words(marks: Marks, diameter_mm: float | None, by_line: Quantity | None) -> str:
    """Say the scale in words, or what is still needed for it; `by_line` is the line's diameter."""
    across = marks.across_px
    if across is None:
        return "Put the ring on the ball to see what a pixel is."
    if not diameter_mm:
        return (
            f"The ball is {across.value:.1f} px across. State its diameter, or draw a line over a "
            "known length."
        )
    said = (
        f"{across.value:.1f} px = {diameter_mm:g} mm, so a pixel is "
        f"{diameter_mm / across.value:.3g} mm."
    )
    if by_line is None:
        return said
    off = by_line.value - diameter_mm
    if abs(off) < max(APART * by_line.sigma, 1e-9):
        return f"{said} The line says {by_line.concise()} mm: it agrees."
    return (
        f"{said} ▲ The line says {by_line.concise()} mm: line, length or diameter is wrong by "
        f"{abs(off) / diameter_mm:.0%}, or the line lies nearer to the camera than the ball."
    )


def unlike_words(marks: Marks, measured_px: float) -> str | None:
    """Say that the ball that was measured is of another size than the ring; None where it is not.

    `measured_px` is the measured diameter.
    """
    across = marks.across_px
    if across is None or abs(across.value - measured_px) < UNLIKE * across.value:
        return None
    return (
        f"the ball that was measured is {measured_px:.1f} px across, the ring {across.value:.1f} "
        "px: another thing was followed; drag the blue border about the ball's flight alone"
    )


def _numbers(given: object, count: int) -> Numbers | None:
    if given is None:
        return None
    if not isinstance(given, list) or len(given) != count:
        raise ValueError(f"{count} numbers are needed, found {given!r}")
    values = tuple(float(value) for value in given)
    if not all(map(math.isfinite, values)):
        raise ValueError(f"finite numbers are needed, found {given!r}")
    return values
