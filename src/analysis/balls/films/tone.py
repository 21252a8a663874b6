"""From the values of a file to light: what mixes in a smear and on a rim is light."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Singles
from analysis.balls.films.film import FilmHead, Picture

BRIGHTNESS = np.array([0.114, 0.587, 0.299])
"""Of blue, green and red (ITU-R BT.601)."""


def _srgb() -> Singles:
    """Return the light of 8-bit values, 0 to 255 (IEC 61966-2-1)."""
    value = np.arange(256) / 255.0
    light = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    return np.asarray(255.0 * light, dtype=np.float32)


SRGB = _srgb()


def light(picture: Picture, head: FilmHead) -> Singles:
    """Return light in linear units, of the picture's shape."""
    if head.encoded and picture.dtype == np.uint8:
        return np.asarray(SRGB[picture], dtype=np.float32)
    return picture.astype(np.float32)
