"""Stated errors set against the scatter of the poses about free flight.

The fit knows the noise of the pixels. What shading and pattern leave is not in it; it shows as
scatter about the flight on either side of the contact, and enlarges all errors of the shot alike.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.errors import ShotRefusedError
from analysis.motion.drift import Drift
from analysis.motion.pattern import Orientations
from analysis.motion.poses import Centres
from analysis.motion.spin import fit_spin
from analysis.motion.split import split_at_contact
from analysis.motion.velocity import fit_flight

Floats = NDArray[np.float64]

MOST = 25.0
"""Beyond this a track is no free flight; its errors stay as they are and the shot is refused."""
NO_DRIFT = Drift(0.0, 1.0)
LEAST_ON_A_SIDE = 4
LEAST_OF_A_COORDINATE = 2
"""Frames that have one: behind another sphere in the mirror no height is measured."""


def enlargement(
    centres: tuple[Centres, Centres],
    turned: tuple[Orientations, Orientations],
    times_s: Floats,
    gravity: float,
) -> tuple[float, float]:
    """Return by how much the variances of centres and of turns are too small, each 1 to MOST.

    1 where no contact is found: what comes after refuses the shot with its reason.
    """
    try:
        split = split_at_contact(*centres, times_s, gravity)
    except ShotRefusedError:
        return 1.0, 1.0
    # The frames next to the contact may hold both motions.
    sides = [(0, split - 1), (split + 1, len(times_s))]
    places: list[tuple[float, int]] = []
    turns: list[tuple[float, int]] = []
    for own, rotation in zip(centres, turned, strict=True):
        for first, last in sides:
            places.append(_flight(own, times_s, gravity, (first, last)))
            turns.append(_turning(rotation, times_s, (first, last)))
    return _pooled(places), _pooled(turns)


def _pooled(parts: list[tuple[float, int]]) -> float:
    freedom = sum(own for _, own in parts)
    chi2 = sum(value * own for value, own in parts) / freedom if freedom else 1.0
    return max(1.0, chi2) if chi2 < MOST else 1.0


def _flight(
    own: Centres, times_s: Floats, gravity: float, side: tuple[int, int]
) -> tuple[float, int]:
    chosen = (own.frames >= side[0]) & (own.frames < side[1])
    measured = np.isfinite(own.sigma[chosen]).sum(axis=0)
    if chosen.sum() < LEAST_ON_A_SIDE or measured.min() < LEAST_OF_A_COORDINATE:
        return 0.0, 0
    path = fit_flight(
        times_s[own.frames[chosen]],
        own.position[chosen],
        own.sigma[chosen],
        NO_DRIFT,
        gravity=gravity,
        reference_s=float(times_s[own.frames[chosen]].mean()),
    )
    return path.chi2_per_dof, int(measured.sum()) - 6


def _turning(own: Orientations, times_s: Floats, side: tuple[int, int]) -> tuple[float, int]:
    chosen = (own.frames >= side[0]) & (own.frames < side[1])
    if chosen.sum() < LEAST_ON_A_SIDE:
        return 0.0, 0
    times = times_s[own.frames[chosen]]
    spin = fit_spin(times, own.rotation[chosen], own.covariance[chosen], NO_DRIFT)
    return spin.chi2_per_dof, 3 * int(chosen.sum()) - 6
