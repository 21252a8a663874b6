"""Centres of a sphere in rig axes, from its outlines in both views."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.outlines import Outline
from analysis.imaging.tracks import Track
from analysis.imaging.views import View, ViewGeometry

Floats = NDArray[np.float64]

LEAST_SIGMA_PX = 0.02
"""No outline is better than its model: markers and shading move it by about this much."""


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


def centres(
    tracks: dict[View, Track],
    views: tuple[ViewGeometry, ...],
    scales_px_per_m: dict[View, float],
    sigma_px: float,
) -> Centres:
    """Place one sphere in rig axes: X and Y from the front view, Z from the top view.

    Frames whose front view lacks the outline are left out.

    Parameters
    ----------
    scales_px_per_m
        Scale of each view.
    sigma_px
        Width of the edge filter: it ties neighbouring edge points together.
    """
    geometry = {g.view: g for g in views}
    frames = sorted(tracks[View.FRONT].outlines)
    position, sigma = np.zeros((len(frames), 3)), np.full((len(frames), 3), 1e-6)
    for i, k in enumerate(frames):
        front, scale = tracks[View.FRONT].outlines[k], scales_px_per_m[View.FRONT]
        origin = geometry[View.FRONT].origin
        position[i, 0] = (front.circle.row - origin[0]) / scale
        position[i, 1] = (front.circle.column - origin[1]) / scale
        sigma[i, :2] = centre_sigma(front, sigma_px) / scale
        if View.TOP not in tracks:
            continue
        position[i, 2], sigma[i, 2] = np.nan, np.inf
        if (top := tracks[View.TOP].outlines.get(k)) is not None:
            scale = scales_px_per_m[View.TOP]
            position[i, 2] = -(top.circle.row - geometry[View.TOP].origin[0]) / scale
            sigma[i, 2] = centre_sigma(top, sigma_px)[0] / scale
    return Centres(np.array(frames, dtype=np.intp), position, sigma)


def centre_sigma(outline: Outline, sigma_px: float) -> Floats:
    """Return the standard errors of row and column, pixels, shape (2,).

    The filter makes edge points within 2 sqrt(pi) sigma of each other repeat one another, so the
    fit's covariance, which takes them as independent, is enlarged by their number in that length.
    """
    rim = 2 * np.pi * outline.circle.radius * max(outline.coverage, 1e-3)
    repeats = max(1.0, 2 * np.sqrt(np.pi) * sigma_px * len(outline.points) / rim)
    covariance = outline.circle.covariance
    return np.array(
        [math.sqrt(float(covariance[a, a]) * repeats + LEAST_SIGMA_PX**2) for a in (0, 1)]
    )
