"""Gravity from a falling sphere: table 6.1 and figure 6.1 of the thesis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from analysis.arrays import Floats, Grey
from analysis.errors import ShotRefusedError
from analysis.imaging.outlines import Place
from analysis.qualification.locating import Way, find_disc, follow_disc, locate

Method = Literal["thesis", "photometric"]

WAY: dict[Method, Way] = {"thesis": "quarters", "photometric": "photometric"}
RADII_PX = (8.0, 40.0)
LEAST_FRAMES = 5
"""A parabola takes three; the rest must show that it is one."""
SAME_RADIUS = 0.08
CLEAR_PX = 3.0
"""From a sphere's rim to the picture's: blur and the edge filter reach so far."""


@dataclass(frozen=True, slots=True, eq=False)
class Fall:
    """One drop.

    Attributes
    ----------
    times_s
        Shape (frames,).
    rows_px
        The sphere's centre, shape (frames,).
    radius_px
        Median over the frames.
    parabola
        Of the rows: px/s^2, px/s, px, highest power first.
    """

    times_s: Floats
    rows_px: Floats
    radius_px: float
    parabola: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Gravity:
    """What a series of drops says of gravity.

    Attributes
    ----------
    values
        m/s^2, one for each drop, with one scale for all, shape (drops,).
    true
        m/s^2.
    scale_px_per_m
        From the sphere's diameter.
    falls
        The drops.
    """

    values: Floats
    true: float
    scale_px_per_m: float
    falls: tuple[Fall, ...]

    @property
    def mean(self) -> float:
        """Mean, m/s^2."""
        return float(self.values.mean())

    @property
    def deviation(self) -> float:
        """Standard deviation of the drops, m/s^2; not a number for a single one."""
        return float(self.values.std(ddof=1)) if len(self.values) > 1 else float("nan")

    @property
    def bias(self) -> float:
        """Relative error of the mean."""
        return self.mean / self.true - 1.0


def measure_fall(frames: Grey, times_s: Floats, method: Method) -> Fall:
    """Follow a falling sphere and fit a parabola to its rows.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns), one sphere in view.
    times_s
        Shape (frames,).

    Raises
    ------
    ShotRefusedError
        Fewer than five frames, or no disc in one of them.
    """
    if len(frames) < LEAST_FRAMES:
        raise ShotRefusedError("frames", f"{len(frames)} frames, {LEAST_FRAMES} are needed")
    starts = follow_disc(frames, *RADII_PX)
    places = np.array(locate(frames, starts, WAY[method]))
    return Fall(
        times_s=times_s,
        rows_px=places[:, 0],
        radius_px=float(np.median(places[:, 2])),
        parabola=np.polyfit(times_s, places[:, 0], 2),
    )


def whole_falls(frames: Grey) -> slice:
    """Return the longest part of a film that shows the whole sphere, clear of every border.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns).

    Raises
    ------
    ShotRefusedError
        Fewer than five frames in a row do.
    """
    found = [_whole_disc(frame) for frame in frames]
    radii = [place[2] for place in found if place is not None]
    usual = float(np.median(radii)) if radii else 0.0
    whole = [place is not None and abs(place[2] / usual - 1.0) < SAME_RADIUS for place in found]
    edges = np.flatnonzero(np.diff(np.array([False, *whole, False], dtype=np.int8)))
    parts = [slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    longest = max(parts, key=lambda part: part.stop - part.start, default=slice(0, 0))
    count = longest.stop - longest.start
    if count < LEAST_FRAMES:
        raise ShotRefusedError(
            "frames",
            f"{count} frames in a row show a whole sphere of {2 * RADII_PX[0]:.0f} to "
            f"{2 * RADII_PX[1]:.0f} px, {LEAST_FRAMES} are needed",
        )
    return longest


def _whole_disc(frame: Grey) -> Place | None:
    """Return the disc of a frame; None where there is none or a border cuts it."""
    try:
        row, column, radius = find_disc(frame, *RADII_PX)
    except ShotRefusedError:
        return None
    rows, columns = frame.shape
    reach = radius + CLEAR_PX
    inside = reach < row < rows - reach and reach < column < columns - reach
    return (row, column, radius) if inside else None


def gravity(falls: Sequence[Fall], diameter_m: float, true: float) -> Gravity:
    """Combine drops of one sphere before one camera.

    The scale is the median radius of all drops against the sphere's: the camera stands still
    between them.

    Parameters
    ----------
    diameter_m
        Of the sphere.
    true
        Gravity at the place, m/s^2.
    """
    scale = 2.0 * float(np.median([fall.radius_px for fall in falls])) / diameter_m
    values = np.array([2.0 * fall.parabola[0] / scale for fall in falls])
    return Gravity(values, true, scale, tuple(falls))
