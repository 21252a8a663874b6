"""One disc in several frames by its grey levels: a shaded sphere, or a flat round marker.

The picture of a disc is I = B (1 - E) + S, with a plane background B, the blurred disc E and its
blurred shading S. What all frames share (background, shading, radius, blur) and each frame's
centre are fitted together, since radius, blur and shading near the limb resemble each other in
one frame (docs/explanation/photometric.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey
from analysis.imaging.outlines import Place
from analysis.photometric.render.shading import (
    HARMONICS,
    ORDER,
    RADIALS,
    STEPS_PER_RADIUS,
    blurred_profiles,
)

AROUND_PX = 6.0
FIRST_BLUR_PX, NARROWEST_PX, WIDEST_PX = 0.85, 0.35, 3.0
NUDGE_PX, NUDGE_BLUR = 0.02, 1e-3
"""Steps of derivatives taken by difference: of a place, and of the blur in radii."""
LONGEST_STEP_PX, LONGEST_BLUR = 0.5, 0.02
MOST_STEPS = 25
SETTLED_PX = 2e-4
"""The last step; what is left after it is far smaller."""


@dataclass(frozen=True, slots=True, eq=False)
class GreyDiscs:
    """A disc in all frames.

    Attributes
    ----------
    centres, sigma
        (row, column) and their standard errors, pixels, shape (frames, 2).
    radius, radius_sigma
        Pixels, common to all frames.
    blur_px
        Standard deviation of lens and pixel together.
    noise
        Standard deviation of the residuals, grey levels.
    """

    centres: Floats
    sigma: Floats
    radius: float
    radius_sigma: float
    blur_px: float
    noise: float


@dataclass(frozen=True, slots=True, eq=False)
class _Pixels:
    """Pixels about the disc in all frames, one after another.

    `row`, `column`, `grey` have shape (pixels,), `frame` the index of each one's frame.
    """

    row: Floats
    column: Floats
    frame: NDArray[np.intp]
    grey: Floats
    shaded: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Shape:
    """Centres (frames, 2) and radius, pixels; blur in units of the radius."""

    centres: Floats
    radius: float
    blur: float


def fit_grey_discs(frames: Grey, starts: list[Place], *, shaded: bool) -> GreyDiscs:
    """Fit one disc to the grey levels of all frames at once.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns).
    starts
        Where the disc stands in each frame, within about a pixel.
    shaded
        True for a sphere under constant light: its shading is a sum of harmonics, the same in
        all frames. False for a flat disc, whose brightness is a plane over the frame.
    """
    pixels = _gather(frames, starts, shaded=shaded)
    radius = float(np.median([start[2] for start in starts]))
    shape = _Shape(np.array([start[:2] for start in starts]), radius, FIRST_BLUR_PX / radius)
    for _ in range(MOST_STEPS):
        jacobian, residual = _equations(pixels, shape)
        step = np.linalg.lstsq(jacobian.T @ jacobian, jacobian.T @ residual, rcond=None)[0]
        shape, longest = _moved(shape, np.asarray(step, dtype=np.float64))
        if longest < SETTLED_PX:
            break
    jacobian, residual = _equations(pixels, shape)
    variance = float(residual @ residual) / max(len(residual) - jacobian.shape[1], 1)
    sigma = np.sqrt(variance * np.diag(np.linalg.pinv(jacobian.T @ jacobian)))
    return GreyDiscs(
        centres=shape.centres,
        sigma=sigma[2 : 2 + shape.centres.size].reshape(-1, 2),
        radius=shape.radius,
        radius_sigma=float(sigma[0]),
        blur_px=shape.blur * shape.radius,
        noise=float(np.sqrt(variance)),
    )


def _moved(shape: _Shape, step: Floats) -> tuple[_Shape, float]:
    """Return the shape after a step, kept short, and the step's longest part, pixels."""
    radius = float(np.clip(step[0], -LONGEST_STEP_PX, LONGEST_STEP_PX))
    blur = float(np.clip(step[1], -LONGEST_BLUR, LONGEST_BLUR))
    centres = np.clip(step[2 : 2 + shape.centres.size], -LONGEST_STEP_PX, LONGEST_STEP_PX)
    moved = _Shape(
        centres=shape.centres + centres.reshape(-1, 2),
        radius=shape.radius + radius,
        blur=float(
            np.clip(shape.blur + blur, NARROWEST_PX / shape.radius, WIDEST_PX / shape.radius)
        ),
    )
    return moved, float(max(np.abs(centres).max(), abs(radius), abs(blur) * shape.radius))


def _gather(frames: Grey, starts: list[Place], *, shaded: bool) -> _Pixels:
    parts = []
    rows, columns = np.mgrid[: frames.shape[1], : frames.shape[2]]
    for k, (row, column, radius) in enumerate(starts):
        near = np.hypot(rows - row, columns - column) < radius + AROUND_PX
        own = np.full(int(np.count_nonzero(near)), k)
        parts.append((rows[near], columns[near], own, frames[k][near]))
    row_all, column_all, frame, grey = (np.concatenate(part) for part in zip(*parts, strict=True))
    return _Pixels(
        row=row_all.astype(np.float64),
        column=column_all.astype(np.float64),
        frame=frame.astype(np.intp),
        grey=grey.astype(np.float64),
        shaded=shaded,
    )


def _offsets(pixels: _Pixels, shape: _Shape) -> tuple[Floats, Floats]:
    """Return row and column of each pixel from its disc's centre, in radii."""
    u = (pixels.row - shape.centres[pixels.frame, 0]) / shape.radius
    v = (pixels.column - shape.centres[pixels.frame, 1]) / shape.radius
    return u, v


def _linear(pixels: _Pixels, shape: _Shape) -> Floats:
    """Return what multiplies the linear unknowns: background, then the disc's brightness.

    Shape (pixels, unknowns).
    """
    u, v = _offsets(pixels, shape)
    table = blurred_profiles(shape.blur).values
    rho = np.hypot(u, v)
    place = np.minimum(rho * STEPS_PER_RADIUS, len(table) - 1.001)
    low = place.astype(np.intp)
    share = (place - low)[:, None]
    needed = slice(None) if pixels.shaded else slice(0, 1)
    radial = (1.0 - share) * table[low, needed] + share * table[low + 1, needed]
    disc = radial[:, 0]
    plane = np.stack([np.ones_like(disc), pixels.row / 100.0, pixels.column / 100.0], 1)
    behind = plane * (1.0 - disc)[:, None]
    if not pixels.shaded:
        return np.concatenate([behind, plane * disc[:, None]], 1)
    turns = _turns(u, v, rho)
    shading = [radial[:, j] * turns[RADIALS[j].angular][sine] for j, sine in HARMONICS]
    return np.concatenate([behind, np.stack(shading, 1)], 1)


def _turns(u: Floats, v: Floats, rho: Floats) -> list[tuple[Floats, Floats]]:
    """Return cosine and sine of every multiple of the angle from the row axis."""
    far = np.maximum(rho, 1e-9)
    cosine, sine = u / far, v / far
    turns = [(np.ones_like(rho), np.zeros_like(rho))]
    for _ in range(ORDER):
        c, s = turns[-1]
        turns.append((c * cosine - s * sine, s * cosine + c * sine))
    return turns


def _equations(pixels: _Pixels, shape: _Shape) -> tuple[Floats, Floats]:
    """Return derivatives and residuals with the best linear unknowns for this shape.

    Columns: radius, blur, row and column of each frame's centre, then the linear unknowns.
    """
    linear = _linear(pixels, shape)
    best = np.linalg.lstsq(linear.T @ linear, linear.T @ pixels.grey, rcond=None)[0]

    def slope(ahead: _Shape, behind: _Shape, apart: float) -> Floats:
        difference = _linear(pixels, ahead) - _linear(pixels, behind)
        return np.asarray(difference @ best / apart)

    def nudged(row: float, column: float, blur: float) -> _Shape:
        return _Shape(shape.centres + np.array([row, column]), shape.radius, shape.blur + blur)

    h = NUDGE_PX
    by_row = slope(nudged(h, 0, 0), nudged(-h, 0, 0), 2 * h)
    by_column = slope(nudged(0, h, 0), nudged(0, -h, 0), 2 * h)
    by_blur = slope(nudged(0, 0, NUDGE_BLUR), shape, NUDGE_BLUR)
    # The picture depends on place and radius through their quotient alone.
    u, v = _offsets(pixels, shape)
    common = np.stack([u * by_row + v * by_column, by_blur], 1)
    own = np.zeros((len(u), 2 * len(shape.centres)))
    every = np.arange(len(u))
    own[every, 2 * pixels.frame], own[every, 2 * pixels.frame + 1] = by_row, by_column
    return np.concatenate([common, own, linear], 1), pixels.grey - linear @ best
