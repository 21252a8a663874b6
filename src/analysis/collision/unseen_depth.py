"""What a camera without a mirror does not see: by how much depth may change an impact's numbers.

Without the mirror Z is taken as constant (thesis, section 3.3). The true spheres stand off each
other in depth and drift in it, which turns the normal and the surface velocity out of the picture;
most of it enters the numbers by its square, so that no derivative tells it. Whole impacts with
depths drawn as tubes scatter them are worked out instead.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from analysis.arrays import Floats
from analysis.collision.impact import ContactState, surface_velocity
from analysis.collision.instant import touching_time

PLACE_SIGMA, SLOPE_SIGMA = 0.015, 0.005
"""Assumed of what sends a sphere: standard deviations of its depth at the contact in diameters, and
of its velocity in depth over its speed. A tube that points to 5 mrad and lies three diameters away
gives as much."""
DRAWS = 500


def depth_spread(
    outcomes: Callable[[Floats], Floats], centre: Floats, radii: tuple[float, float]
) -> Floats:
    """Return the mean squares and products of what unseen depth changes, shape (35, 35).

    Parameters
    ----------
    outcomes, centre
        As in `coefficients.measure_impact`: from states (n, 37) to numbers (n, 35).
    radii
        Of a and b, m.

    Returns
    -------
    Not a number where no drawn pair touches.

    Notes
    -----
    After contact each sphere drifts in depth as before, and as the impulses have changed it: along
    the normal by what v_n changes, and by friction along the incident surface velocity, in depth as
    in the picture.
    """
    states = _drawn(outcomes(centre[None])[0], centre, radii)
    paths = states[:, :24].reshape(-1, 4, 2, 3)
    between = paths[:, 1] - paths[:, 0]
    touch = ~np.isnan(touching_time(between[:, 0], between[:, 1], np.array(sum(radii))))
    if not touch.any():
        return np.full((len(outcomes(centre[None])[0]),) * 2, np.nan)
    change = np.nan_to_num(outcomes(states[touch]) - outcomes(centre[None]))
    return np.asarray(change.T @ change / touch.sum())


def _drawn(numbers: Floats, centre: Floats, radii: tuple[float, float]) -> Floats:
    """Return the state with drawn depths, shape (`DRAWS`, 37); the same draws each time."""
    before, after = (ContactState(*state) for state in numbers[10:34].reshape(2, 4, 3))
    normal = numbers[1:4]
    change = (after.velocity_b - after.velocity_a) - (before.velocity_b - before.velocity_a)
    incident = surface_velocity(before, normal, radii)
    square = float(incident @ incident)
    friction = float(change @ incident) / square if square > 0.0 else 0.0
    rng = np.random.default_rng(0)
    speeds = [np.linalg.norm(v) for v in (before.velocity_a, before.velocity_b)]
    places = rng.standard_normal((DRAWS, 2)) * PLACE_SIGMA * 2.0 * np.array(radii)
    drifts = rng.standard_normal((DRAWS, 2)) * SLOPE_SIGMA * np.array(speeds)
    tilted = np.tile(normal, (DRAWS, 1))
    tilted[:, 2] = (places[:, 1] - places[:, 0]) / sum(radii)
    tilted /= np.linalg.norm(tilted, axis=1)[:, None]
    moving = ContactState(
        _in_depth(before.velocity_a, drifts[:, 0]),
        _in_depth(before.velocity_b, drifts[:, 1]),
        np.tile(before.spin_a, (DRAWS, 1)),
        np.tile(before.spin_b, (DRAWS, 1)),
    )
    slip = surface_velocity(moving, tilted, radii)[:, 2]
    kick = float(change @ normal) * tilted[:, 2] + friction * slip
    volumes = np.array(radii) ** 3
    share_a, share_b = volumes / volumes.sum()
    states = np.tile(centre, (DRAWS, 1))
    states[:, [2, 14]] = places[:, :1]
    states[:, [8, 20]] = places[:, 1:]
    states[:, [5, 17]], states[:, [11, 23]] = drifts[:, :1], drifts[:, 1:]
    states[:, 17] -= share_b * kick
    states[:, 23] += share_a * kick
    return states


def _in_depth(velocity: Floats, drifts: Floats) -> Floats:
    moved = np.tile(velocity, (len(drifts), 1))
    moved[:, 2] = drifts
    return moved
