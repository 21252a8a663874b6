"""Stated errors set against the scatter of the poses about free flight.

Errors of a fit contain the noise of the pixels alone. Residuals of shading and pattern add scatter
about the flight on either side of the contact, by which all errors of the shot are enlarged.
How much the air bends a flight is not known here and is left open: taken for scatter, a drag of
0.8 made errors of centres a quarter too large (`python -m benchmarks.coefficients`).
"""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.errors import ShotRefusedError
from analysis.motion.drift import Drift
from analysis.motion.pattern import Orientations
from analysis.motion.poses import Centres
from analysis.motion.spin import fit_spin
from analysis.motion.split import split_at_contact
from analysis.motion.velocity import fit_flight

MOST = 25.0
"""Beyond this a track is no free flight; its errors stay as they are and the shot is refused."""
NO_DRIFT = Drift(0.0, 1.0)
LEAST_ON_A_SIDE, LEAST_FREEDOM = 4, 20
UNKNOWNS, LEAST_BEND = 7, 1e-12
"""Of a flight: two a coordinate, and drag; the bend of one at rest, squared and over its errors."""
LEAST_OF_A_COORDINATE = 2
"""Frames that have one: behind another sphere in the mirror no height is measured."""


def birge_ratios(
    centres: tuple[Centres, Centres],
    turned: tuple[Orientations, Orientations],
    times_s: Floats,
    gravity: float,
) -> tuple[float, float]:
    """Return by how much the variances of centres and of turns are too small, each 1 to MOST.

    1 where no contact is found: what comes after refuses the shot with its reason.
    """
    sides = _sides(centres, times_s, gravity)
    places = [_flight(own, times_s, gravity, side) for own in centres for side in sides]
    turns = [_turning(own, times_s, side) for own in turned for side in sides]
    return max(1.0, _pooled(places)[0]), max(1.0, _pooled(turns)[0])


def scatter_ratio(centres: tuple[Centres, Centres], times_s: Floats, gravity: float) -> float:
    """Return the variance of centres about free flight over the stated one.

    Points scatter about a circle also by what the light does to a sphere's outline, which is the
    same in all frames: errors of outlines by that scatter are too large as well as too small.
    1 where flights have less than `LEAST_FREEDOM` together.
    """
    sides = _sides(centres, times_s, gravity)
    ratio, freedom = _pooled(
        [_flight(own, times_s, gravity, side) for own in centres for side in sides]
    )
    return ratio if freedom >= LEAST_FREEDOM else 1.0


def _sides(
    centres: tuple[Centres, Centres], times_s: Floats, gravity: float
) -> list[tuple[int, int]]:
    """Return first and past the last frame of each side, none where no contact is found."""
    try:
        split = split_at_contact(*centres, times_s, gravity)
    except ShotRefusedError:
        return []
    # The frames next to the contact may hold both motions.
    return [(0, split - 1), (split + 1, len(times_s))]


def _pooled(parts: list[tuple[float, int]]) -> tuple[float, int]:
    """Return chi-squared over the freedom, 1 where there is none or too much, and the freedom."""
    freedom = sum(own for _, own in parts)
    chi2 = sum(value * own for value, own in parts) / freedom if freedom else 1.0
    return (chi2 if chi2 < MOST else 1.0), freedom


def _flight(
    own: Centres, times_s: Floats, gravity: float, side: tuple[int, int]
) -> tuple[float, int]:
    chosen = (own.frames >= side[0]) & (own.frames < side[1])
    measured = np.isfinite(own.sigma[chosen]).sum(axis=0)
    freedom = int(measured.sum()) - UNKNOWNS
    if chosen.sum() < LEAST_ON_A_SIDE or measured.min() < LEAST_OF_A_COORDINATE or freedom < 1:
        return 0.0, 0
    times, centres = times_s[own.frames[chosen]], own.position[chosen]
    path = fit_flight(
        *(times, centres, own.sigma[chosen], NO_DRIFT),
        gravity=gravity,
        reference_s=float(times.mean()),
    )
    tau = (times - times.mean())[:, None]
    fallen = path.position + path.velocity * tau + path.acceleration * tau**2 / 2
    slowed = np.linalg.norm(path.velocity) * path.velocity * tau**2 / 2
    seen = np.isfinite(own.sigma[chosen])
    left, bend = (
        _off_lines(np.where(seen, values, 0.0), tau[:, 0], own.sigma[chosen])
        for values in (centres - fallen, slowed)
    )
    explained = float((left * bend).sum()) ** 2 / max(float((bend**2).sum()), LEAST_BEND)
    return (float((left**2).sum()) - explained) / freedom, freedom


def _off_lines(values: Floats, tau: Floats, sigma: Floats) -> Floats:
    """Return values (n, 3) over sigma, less their lines; 0 where not measured."""
    white, time = 1.0 / sigma, tau[:, None]
    weight = white**2
    sums = [(weight * time**power).sum(axis=0) for power in range(3)]
    own, by_time = (weight * values).sum(axis=0), (weight * time * values).sum(axis=0)
    slope = (sums[0] * by_time - sums[1] * own) / (sums[0] * sums[2] - sums[1] ** 2)
    return np.asarray(white * (values - (own - slope * sums[1]) / sums[0] - slope * time))


def _turning(own: Orientations, times_s: Floats, side: tuple[int, int]) -> tuple[float, int]:
    chosen = (own.frames >= side[0]) & (own.frames < side[1])
    if chosen.sum() < LEAST_ON_A_SIDE:
        return 0.0, 0
    times = times_s[own.frames[chosen]]
    spin = fit_spin(times, own.rotation[chosen], own.covariance[chosen], NO_DRIFT)
    return spin.chi2_per_dof, 3 * int(chosen.sum()) - 6
