"""Where the camera shows the spheres, and where a laboratory that trusts its camera puts them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulators.challenge.nature import Nature
from simulators.world.optics import Optics

Floats = NDArray[np.float64]

OPTICS = Optics(
    rows=320,
    columns=400,
    front_origin_px=(224.0, 200.0),
    top_origin_px=(64.0, 200.0),
    front_rows=(128, 320),
    top_rows=(0, 128),
)
"""Magnification and noise of the rig's camera, and a field that holds the fast shots to the end."""


def apparent(centres: Floats, times_s: Floats, nature: Nature, optics: Optics) -> Floats:
    """Return what is read off the pictures, m, for true centres (S, F, 2, 3) in m.

    Each centre is imaged in the front view and in the mirror as this nature has it, then read
    back as the stated optics say: X and Y from the front view, Z from the mirror. `times_s`
    (S, F) counts from the first frame.
    """
    scale = optics.scale_px_per_m
    front, top = _images(centres, nature, optics)
    shake = nature.shake_px * np.sin(2.0 * np.pi * nature.shake_hz * times_s)[:, :, None]
    seen = np.empty_like(centres)
    row, column = picture(*front, nature, optics)
    seen[..., 0] = (row + shake - optics.front_origin_px[0]) / scale
    seen[..., 1] = (column - optics.front_origin_px[1]) / scale
    row, _ = picture(*top, nature, optics)
    seen[..., 2] = (optics.top_origin_px[0] - row - shake) / scale
    return seen


def _images(
    centres: Floats, nature: Nature, optics: Optics
) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Return (row, column), pixels, in the front view and in the mirror, before the lens."""
    scale = optics.scale_px_per_m * (1.0 + nature.image_scale)
    x, y, z = np.moveaxis(centres, -1, 0)
    # A mirror turned by an angle turns what it shows by twice that angle.
    turned = np.cos(2.0 * nature.mirror_rad) * z - np.sin(2.0 * nature.mirror_rad) * x
    front = optics.front_origin_px[0] + scale * x, optics.front_origin_px[1] + scale * y
    top = optics.top_origin_px[0] - scale * turned, optics.top_origin_px[1] + scale * y
    return front, top


def picture(row: Floats, column: Floats, nature: Nature, optics: Optics) -> tuple[Floats, Floats]:
    """Return pixels as the lens, the roll of the camera and the shape of its pixels leave them.

    Rows and columns are of any shape; integers are pixel centres.
    """
    down, across = row - (optics.rows - 1) / 2.0, column - (optics.columns - 1) / 2.0
    corner = ((optics.rows - 1) ** 2 + (optics.columns - 1) ** 2) / 4.0
    radial = 1.0 + nature.distortion * (down**2 + across**2) / corner
    down, across = down * radial, across * radial
    cosine, sine = np.cos(nature.roll_rad), np.sin(nature.roll_rad)
    down, across = cosine * down - sine * across, cosine * across + sine * down
    down = down * (1.0 + nature.pixel_aspect)
    return down + (optics.rows - 1) / 2.0, across + (optics.columns - 1) / 2.0
