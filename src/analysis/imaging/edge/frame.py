"""One frame's edges, computed once and shared by the steps that follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey, Singles, as_singles
from analysis.compiled import compiled
from analysis.imaging.edge.edges import half_kernels
from analysis.imaging.edge.facet import BORDER_SIGMAS, EdgePoints
from analysis.imaging.edge.windows import Filters, edges_about

NOISE_BLOCK_PX = 8


@dataclass(frozen=True, slots=True)
class EdgeSettings:
    """How edges are found.

    Attributes
    ----------
    sigma_px
        Standard deviation of the Laplacian of Gaussian. The thesis has 2, which needs markers at
        least 8 pixels across; with markers of 6 pixels 1.2 halves every error
        (docs/decisions/0002-filter-width.md).
    least_strength
        Gradient of the smoothed frame below which a crossing is noise, grey levels per pixel;
        None: from the frames' own noise.
    samples_per_pixel
        3 or 4 samples the facet as the thesis does; None takes its exact root.
    """

    sigma_px: float = 1.2
    least_strength: float | None = None
    samples_per_pixel: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FrameEdges:
    """Edge points of a frame and the label of the curve that each belongs to, shape (points,)."""

    shape: tuple[int, int]
    points: EdgePoints
    labels: NDArray[np.int32]


class FilmEdges:
    """Edges of a film's frames, found when they are asked for."""

    def __init__(self, frames: Grey, settings: EdgeSettings, least_strength: float) -> None:
        self.frames, self.settings, self.least_strength = frames, settings, least_strength
        self._whole: dict[int, FrameEdges] = {}

    def __len__(self) -> int:
        return len(self.frames)

    def whole(self, k: int) -> FrameEdges:
        """Return all edges of a frame."""
        if k not in self._whole:
            self._whole[k] = find_edges(self.frames[k], self.settings, self.least_strength)
        return self._whole[k]


def noise_sd(frames: Grey) -> float:
    """Estimate the read noise in grey levels from the pixels' differences across a diagonal.

    The mixed second difference of four neighbouring pixels vanishes on any linear shading and has
    twice the noise of one pixel. The median over small blocks leaves out those that an edge
    crosses. Never below the rounding of 8 bits, 1/sqrt(12).
    """
    sample = as_singles(frames[:: max(1, len(frames) // 8)])
    variance = np.median(block_squares(sample))
    return float(max(np.sqrt(variance) / 2.0, 12**-0.5))


@compiled
def block_squares(frames: Singles) -> Floats:
    """Return the mean squares of the mixed second differences over blocks of frames, flat."""
    count, rows, columns = frames.shape
    down, across = (rows - 1) // NOISE_BLOCK_PX, (columns - 1) // NOISE_BLOCK_PX
    squares = np.zeros((count * down, across))
    line = np.empty(across * NOISE_BLOCK_PX, dtype=np.int32)
    for n in range(count * down):
        frame, first = frames[n // down], n % down * NOISE_BLOCK_PX
        line[:] = 0
        for r in range(first, first + NOISE_BLOCK_PX):
            upper, lower, after, below = frame[r], frame[r + 1], frame[r, 1:], frame[r + 1, 1:]
            for c in range(np.uint64(line.size)):
                mixed = np.int32(below[c]) - np.int32(lower[c])
                mixed -= np.int32(after[c]) - np.int32(upper[c])
                line[c] += mixed * mixed
        for b in range(across):
            squares[n, b] = line[b * NOISE_BLOCK_PX : (b + 1) * NOISE_BLOCK_PX].sum()
    return squares.ravel() / NOISE_BLOCK_PX**2


def gradient_threshold(noise: float, sigma_px: float) -> float:
    """Return the gradient that noise alone reaches once in about a million pixels.

    White noise of standard deviation s smoothed by a Gaussian has a gradient component of
    standard deviation s / (sqrt(8 pi) sigma^2).
    """
    component = noise / (np.sqrt(8 * np.pi) * sigma_px**2)
    return float(max(5.3 * component, 0.5))


def filters(settings: EdgeSettings, least_strength: float) -> Filters:
    """Return what `windows.edges_about` filters with."""
    # Nearer to the border the filter sees the frame's made-up continuation.
    border = max(1, round(BORDER_SIGMAS * settings.sigma_px))
    limits = float(least_strength), border, settings.samples_per_pixel or 0
    return half_kernels(settings.sigma_px), limits


def find_edges(frame: Grey, settings: EdgeSettings, least_strength: float) -> FrameEdges:
    """Filter a whole frame, find its edge points and label its curves."""
    rows, columns = frame.shape
    everywhere = np.array([[rows / 2, columns / 2, max(rows, columns)]])
    plain = as_singles(frame)
    filled, pixels, labels = edges_about(plain, everywhere, *filters(settings, least_strength))
    return FrameEdges((rows, columns), EdgePoints(*filled, *pixels), labels)
