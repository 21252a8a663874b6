"""Camera parameters from the pixels of all shots, with each shot's poses as nuisance parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.calibration.bending import FAULTS, by_faults
from analysis.photometric.follow.film import Film, sights_of
from analysis.photometric.learn.appearance import Appearance, profiles_of
from analysis.photometric.learn.shared import (
    add_frame,
    shared_prior,
    shared_size,
    tangents_of,
    together,
)
from analysis.photometric.learn.training_view import TrainingView
from analysis.photometric.render.pixel_rows import MARKERS_SHARE, SCALE, STRETCH, VIEW_SHARE
from analysis.photometric.render.shading import NUDGE
from analysis.photometric.render.sight import Equations

LIMIT = 12.0
"""Residual that counts no more, in units of the noise; a fault of the camera leaves large ones."""
WIDEST_STRETCH = 0.05
WIDEST_FAULTS = np.array([2.0, 0.1, 0.1, 0.2, 5.0])
"""Widths of the priors, wide so that the shots alone decide."""


@dataclass(frozen=True, slots=True, eq=False)
class PixelEstimate:
    """Camera parameters from the pixels of some shots, V views.

    Attributes
    ----------
    change
        To what is known: log radius by the markers, log scales of the views behind the front one
        against it (V - 1), stretch of the rows in each view (V), faults (`bending`).
    covariance
        By the noise of the pixels alone.
    """

    change: Floats
    covariance: Floats


def normal_equations(film: Film, known: Appearance) -> tuple[Equations, Equations]:
    """Return the equations of what one shot shares with the others, for spheres a and b."""
    wider, views = known.looks(NUDGE), len(known.camera.views)
    both = []
    for i, sphere in enumerate(known.spheres):
        size = shared_size(len(sphere.markers), views, FAULTS)
        equations = Equations(np.zeros((size, size)), np.zeros(size))
        tangents = tangents_of(sphere.markers)
        training = TrainingView(
            (wider[i].discs, wider[i].surfaces), profiles_of(known, i), tangents, LIMIT
        )
        for sight, stance in sights_of([film], known, i):
            add_frame(sight, stance, training, equations, by_faults)
        both.append(equations)
    return both[0], both[1]


def estimate(shots: Sequence[tuple[Equations, Equations]], known: Appearance) -> PixelEstimate:
    """Solve the equations of some shots together."""
    weight: Floats | None = None
    aim: Floats | None = None
    for i, sphere in enumerate(known.spheres):
        normal = np.sum([shot[i].normal for shot in shots], axis=0)
        right = np.sum([shot[i].right for shot in shots], axis=0)
        own, at = _freed(normal, tangents_of(sphere.markers), len(known.camera.views))
        inverse = np.linalg.inv(own)
        part = np.linalg.inv(inverse[np.ix_(at, at)])
        weighted = part @ (inverse @ right)[at]
        weight = part if weight is None else weight + part
        aim = weighted if aim is None else aim + weighted
    covariance = np.linalg.inv(np.asarray(weight))
    return PixelEstimate(covariance @ np.asarray(aim), covariance)


def _freed(normal: Floats, tangents: Floats, views: int) -> tuple[Floats, list[int]]:
    """Return the equations with priors, and the indices of what a `PixelEstimate` holds."""
    prior = shared_prior(len(tangents), views, WIDEST_FAULTS)
    first = 2 * len(tangents) + MARKERS_SHARE
    stretches = [first + VIEW_SHARE * view + STRETCH for view in range(views)]
    ratios = [first + VIEW_SHARE * view + SCALE for view in range(1, views)]
    prior[stretches] = WIDEST_STRETCH
    faults = range(len(normal) - FAULTS, len(normal))
    held = normal + np.diag(prior**-2.0)
    held[: first - MARKERS_SHARE, : first - MARKERS_SHARE] += together(tangents)
    return held, [first - 1, *ratios, *stretches, *faults]
