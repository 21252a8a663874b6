"""Flat discs drawn by area on sub-pixels, where every edge is known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from analysis.imaging.edge.frame import EdgeSettings, FrameEdges, find_edges

Floats = NDArray[np.float64]
Frames = NDArray[np.uint8]
Place = tuple[float, float, float]

SUBPIXELS = 8
BACKGROUND, SURFACE, MARKER = 40.0, 160.0, 60.0
SETTINGS = EdgeSettings(sigma_px=1.2)
THRESHOLD = 4.0


def coverage(place: Place, shape: tuple[int, int]) -> Floats:
    """Return the share of each pixel that lies in the disc (row, column, radius)."""
    row, column, radius = place
    fine = (np.arange(SUBPIXELS) + 0.5) / SUBPIXELS - 0.5
    rows = (np.arange(shape[0])[:, None] + fine).ravel() - row
    columns = (np.arange(shape[1])[:, None] + fine).ravel() - column
    inside = (rows[:, None] ** 2 + columns[None, :] ** 2 <= radius**2).astype(np.float64)
    blocks = inside.reshape(shape[0], SUBPIXELS, shape[1], SUBPIXELS)
    return np.asarray(blocks.mean(axis=(1, 3)))


def draw(
    discs: Sequence[Place],
    shape: tuple[int, int] = (96, 120),
    *,
    markers: Sequence[Place] = (),
    blur_px: float = 0.8,
) -> Floats:
    """Draw bright discs, with dark markers inside them, and blur them as a lens does."""
    frame = np.full(shape, BACKGROUND)
    bright = np.zeros(shape)
    for disc in discs:
        bright = np.maximum(bright, coverage(disc, shape))
    frame += (SURFACE - BACKGROUND) * bright
    for marker in markers:
        frame -= (SURFACE - MARKER) * coverage(marker, shape) * bright
    return np.asarray(gaussian_filter(frame, blur_px, mode="nearest"))


def grey(frame: Floats, noise: float = 0.0, seed: int = 0) -> Frames:
    """Round to 8 bit, with read noise."""
    noisy = frame + noise * np.random.default_rng(seed).standard_normal(frame.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def edges_of(frame: Floats, noise: float = 0.0, seed: int = 0) -> FrameEdges:
    """Find the edges of a drawing."""
    return find_edges(grey(frame, noise, seed), SETTINGS, THRESHOLD)
