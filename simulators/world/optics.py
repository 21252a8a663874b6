"""Camera, mirror and light: what appears where in a frame, and how bright."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from simulators.world.lamp import Lamp
from simulators.world.sensor import Sensor


@dataclass(frozen=True, slots=True)
class Lighting:
    """How a plain sphere is lit in one view.

    Grey level before the lens: `brightness` (1 - `limb_darkening` (1 - cos t)) (1 + `side_light`
    s . n), where t is the angle from the viewer, n the surface normal, and s the unit direction
    (`side_row`, `side_column`) in the image plane.
    """

    brightness: float
    limb_darkening: float
    side_light: float
    side_row: float
    side_column: float


@dataclass(frozen=True, slots=True)
class Optics:
    """Camera, mirror and light.

    Integer pixel coordinates are pixel centres, (row, column) from the upper left. The front view
    shows a point at row = front_origin[0] + scale X, column = front_origin[1] + scale Y; the
    mirror at row = top_origin[0] - scale Z, column = top_origin[1] + scale Y.

    Parameters
    ----------
    rows, columns
        Size of a full frame in pixels.
    scale_px_per_m
        Magnification of both views (orthographic).
    front_rows, top_rows
        Half-open row ranges of the two views.
    background, background_per_row, background_per_column
        Grey level at the upper left corner and its slope.
    texture_grey
        Standard deviation of blotches that stand still behind the spheres, of a few pixels each.
    blur_px
        Standard deviation of the lens's Gaussian point spread.
    defocus_px
        Radius of the even disc that a point out of focus is spread over besides.
    flicker
        Share by which all light rises and falls, twice in a period of mains of 50 Hz.
    exposure_s
        Shutter time; a picture is the mean over it, centred on the picture's time.
    noise_grey
        Standard deviation of the read noise in grey levels.
    mirror_rad
        Turn of the mirror about Y from 45 degrees; what it shows turns by twice that.
    distance_m
        From the camera's pinhole to the plane Z = 0, along its axis, which meets the frame's
        middle. The mirror then shows the spheres from farther away, and smaller (`pinhole`);
        `scale_px_per_m` holds for the direct view at the origin. None: from infinity.
    lamp
        Light of the scene in rig axes; None: that of each view by itself.
    sensor
        What the sensor makes of the light.
    """

    rows: int = 192
    columns: int = 240
    scale_px_per_m: float = 1574.8
    front_origin_px: tuple[float, float] = (132.0, 120.0)
    top_origin_px: tuple[float, float] = (46.0, 120.0)
    front_rows: tuple[int, int] = (88, 192)
    top_rows: tuple[int, int] = (0, 88)
    background: float = 33.0
    background_per_row: float = 0.012
    background_per_column: float = 0.045
    front_light: Lighting = Lighting(142.0, 0.34, 0.14, -0.8, -0.6)
    top_light: Lighting = Lighting(134.0, 0.30, 0.20, -0.5, 0.866)
    texture_grey: float = 0.0
    blur_px: float = 0.8
    defocus_px: float = 0.0
    flicker: float = 0.0
    exposure_s: float = 1.0e-4
    noise_grey: float = 1.5
    mirror_rad: float = 0.0
    distance_m: float | None = None
    lamp: Lamp | None = None
    sensor: Sensor = field(default_factory=Sensor)


@dataclass(frozen=True, slots=True)
class View:
    """How rig axes appear in one of the two views.

    `axes` (3, 3) takes a rig vector to (row, column, toward the viewer); `origin_px` is where
    X = Y = Z = 0 appears.
    """

    axes: NDArray[np.float64]
    origin_px: tuple[float, float]
    light: Lighting

    def centre_px(self, point: NDArray[np.float64], scale_px_per_m: float) -> tuple[float, float]:
        """Return (row, column) of a point (3,) in m; integers are pixel centres."""
        seen = self.axes @ point * scale_px_per_m
        return self.origin_px[0] + float(seen[0]), self.origin_px[1] + float(seen[1])


def front_view(optics: Optics) -> View:
    """Return the direct view along -Z: rows down X, columns along Y."""
    return View(np.eye(3), optics.front_origin_px, optics.front_light)


def top_view(optics: Optics) -> View:
    """Return the view from above in the mirror: rows against Z, columns along Y."""
    sine, cosine = np.sin(2.0 * optics.mirror_rad), np.cos(2.0 * optics.mirror_rad)
    axes = np.array([[sine, 0.0, -cosine], [0.0, 1.0, 0.0], [-cosine, 0.0, -sine]])
    return View(axes, optics.top_origin_px, optics.top_light)


def picture_rows(optics: Optics, rows: int | None = None) -> tuple[int, int]:
    """Return the half-open range of the full frame's rows that a picture of `rows` rows shows.

    A frame of the EktaPro 1000 is split into 1, 2, 3, 4 or 6 pictures; each shows the rows about
    the middle of the frame (thesis appendix A; that they are the middle ones is our choice).

    Raises
    ------
    ValueError
        `rows` is none of 192, 96, 64, 48, 32 (for a frame of 192 rows).
    """
    allowed = [optics.rows // number for number in (1, 2, 3, 4, 6)]
    if rows is None:
        rows = optics.rows
    if rows not in allowed:
        raise ValueError(f"a picture has one of {allowed} rows, asked for {rows}")
    first = (optics.rows - rows) // 2
    return first, first + rows
