"""Where a picture differs from the scene that stands still: flying spheres before any background.

A wall with a pattern, a rail or the mirror's rim can have more edges than the spheres. What moves
stands out all the same, to about a pixel. A sphere at rest belongs to the scene and is not seen.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Grey

STILL_SHARE = 1 / 3
"""Of the frames: a sphere may cover the scene behind it in all others."""
SMOOTHED_PX = 0.7
LEAST_NOISES = 5.0
CLOSED_PX = 7
"""Gaps where a sphere is by chance as bright as the scene behind it."""
SOFTENED_PX = 1.0
BRIGHT = 200.0


def silhouettes(frames: Grey, noise_grey: float) -> NDArray[np.uint8]:
    """Return pictures that are bright where the frames differ from what stands still.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns).
    noise_grey
        Standard deviation of a pixel.
    """
    still = still_scene(frames)
    # Smoothed over more than its own width, noise is that much smaller.
    noise = noise_grey / max(1.0, np.sqrt(4 * np.pi) * SMOOTHED_PX)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (CLOSED_PX, CLOSED_PX))
    seen = np.empty(frames.shape, np.uint8)
    for k, frame in enumerate(frames):
        off = cv2.GaussianBlur(frame.astype(np.float32) - still, (0, 0), SMOOTHED_PX)
        other = (np.abs(off) > LEAST_NOISES * noise).astype(np.uint8)
        closed = cv2.morphologyEx(other, cv2.MORPH_CLOSE, kernel)
        opened = cv2.morphologyEx(closed, cv2.MORPH_OPEN, kernel)
        soft = cv2.GaussianBlur(opened.astype(np.float32) * BRIGHT, (0, 0), SOFTENED_PX)
        seen[k] = np.rint(soft).astype(np.uint8)
    return seen


def still_scene(frames: Grey) -> NDArray[np.float32]:
    """Return the grey level that each pixel shows most often, shape (rows, columns).

    The mean of the narrowest interval that holds a third of a pixel's values (the shorth's
    relative): a median is wrong where a slow sphere covers a pixel in most frames.
    """
    ordered = np.sort(frames, axis=0).astype(np.float32)
    held = max(2, round(STILL_SHARE * len(frames)))
    if held >= len(frames):
        return np.asarray(np.median(ordered, axis=0), dtype=np.float32)
    first = np.argmin(ordered[held - 1 :] - ordered[: -held + 1], axis=0)
    within = np.take_along_axis(ordered, first[None] + np.arange(held)[:, None, None], axis=0)
    return np.asarray(within.mean(axis=0), dtype=np.float32)
