"""Centres of a sphere in rig axes, from its outlines in both views."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.imaging.film_discs import FilmDiscs
from analysis.imaging.views import View, ViewGeometry

LEAST_SIGMA_PX = 0.02
"""No outline is better than its model: markers and shading move it by about this much."""
CONSTANT_Z_SIGMA_M = 1e-6
"""Of a coordinate that is none, so that a fit leaves it where it is."""


@dataclass(frozen=True, slots=True, eq=False)
class Centres:
    """Centre of one sphere by frame.

    Attributes
    ----------
    frames
        Indices of the frames, shape (n,).
    position, sigma
        m in rig axes, shape (n, 3). Z is NaN with an infinite sigma in a frame whose top view
        lacks the sphere; without any top view it is constant, 0.
    """

    frames: NDArray[np.intp]
    position: Floats
    sigma: Floats

    def without_depth(self) -> Centres:
        """Return the places as a front view alone gives them, Z constant."""
        position, sigma = self.position.copy(), self.sigma.copy()
        position[:, 2], sigma[:, 2] = 0.0, CONSTANT_Z_SIGMA_M
        return Centres(self.frames, position, sigma)


def centres(
    discs: FilmDiscs,
    sphere: int,
    views: tuple[ViewGeometry, ...],
    scales_px_per_m: dict[View, float],
    widths_px: tuple[float, float],
) -> Centres:
    """Place one sphere in rig axes: X and Y from the front view, Z from the top view.

    Frames whose front view lacks the outline are left out.

    Parameters
    ----------
    sphere
        0 for a, 1 for b.
    scales_px_per_m
        Scale of each view.
    widths_px
        Width of the edge filter, which ties neighbouring edge points together, and the least
        standard error of an outline's place.
    """
    geometry = {g.view: g for g in views}
    front = sphere, discs.views.index(View.FRONT)
    frames = np.flatnonzero(discs.found[front])
    position, sigma = np.zeros((len(frames), 3)), np.full((len(frames), 3), CONSTANT_Z_SIGMA_M)
    scale = scales_px_per_m[View.FRONT]
    position[:, :2] = (discs.circles[front][frames, :2] - geometry[View.FRONT].origin) / scale
    sigma[:, :2] = centre_sigmas(discs, front, *widths_px)[frames] / scale
    if View.TOP in discs.views:
        top, scale = (sphere, discs.views.index(View.TOP)), scales_px_per_m[View.TOP]
        seen = discs.found[top][frames]
        height = -(discs.circles[top][frames, 0] - geometry[View.TOP].origin[0]) / scale
        position[:, 2] = np.where(seen, height, np.nan)
        errors = centre_sigmas(discs, top, *widths_px)[frames, 0] / scale
        sigma[:, 2] = np.where(seen, errors, np.inf)
    return Centres(frames, position, sigma)


def centre_sigmas(
    discs: FilmDiscs, seat: tuple[int, int], sigma_px: float, least_px: float = LEAST_SIGMA_PX
) -> Floats:
    """Return the standard errors of row and column of a sphere's outlines in one view, pixels.

    The filter makes edge points within 2 sqrt(pi) sigma of each other repeat one another, so the
    fit's covariance, which takes them as independent, is enlarged by their number in that length.

    Parameters
    ----------
    seat
        Sphere and view, as indices.

    Returns
    -------
    Shape (frames, 2); anything in a frame without outline.
    """
    rim = 2 * np.pi * discs.circles[seat][:, 2] * np.maximum(discs.coverage[seat], 1e-3)
    points = np.diff(discs.spans[seat], axis=1)[:, 0]
    repeats = np.maximum(1.0, 2 * np.sqrt(np.pi) * sigma_px * points / np.maximum(rim, 1e-9))
    variance = np.einsum("kaa->ka", discs.covariance[seat])[:, :2]
    return np.asarray(np.sqrt(variance * repeats[:, None] + least_px**2))
