"""Impacts from poses: both spheres' free flights before and after contact, each by itself.

The flights are those of `analysis.model.sides`, 48 numbers a shot. About the fitted campaign the
poses are linear in them, so that one step sets them free of any law, slow errors in their
covariance. The normal is that of first touch on the paths before contact. A shot is left out when
its poses are no free flight, never because its impact is unlike the others.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2 as chi2_distribution

from analysis.model.comparison import KINDS, Comparison, compare
from analysis.model.fit import Fit
from analysis.model.poses import PoseData
from analysis.model.sides import NUMBERS, Flights
from analysis.model.unseen import spins_unknown
from analysis.results.impacts import V_S, V_S_AFTER, Impacts, LeftOut, told

Floats = NDArray[np.float64]

LEAST_INFORMATION = 1e-9
"""Of the largest in its block, each scaled to one: less is the rounding of what was not seen."""
ALARM_SHARE = 0.005
"""Of campaigns without a bad shot this share has one whose flights are called no free ones."""
PHYSICS_SHARE = 0.15
"""If more shots than this look bad, it is the air, gravity or the camera, and all stay."""
STEP = 0.1
"""Of each number's standard error, for derivatives."""


def pose_impacts(data: PoseData, fit: Fit) -> Impacts:
    """Measure the impact of every shot from its poses alone.

    Parameters
    ----------
    data
        Poses, frames inside the contact left out.
    fit
        Of the hard-sphere operator to them: the point about which the flights are set free.
    """
    line, here = compare(replace(data, jitter_s=0.0), fit.states, fit.theory)
    blocks = _inverse(line.gram)
    pulled = line.pulled.reshape(len(data.shots), KINDS, -1, 1)
    numbers = _numbers(here.sides) + (blocks @ pulled).reshape(-1, NUMBERS)
    radii = (data.bodies[0].radius, data.bodies[1].radius)
    velocities = scalars(numbers, radii)
    covariance = _carried(numbers, blocks, radii)
    unknown = spins_unknown(data).any(axis=1)
    velocities[unknown, V_S] = velocities[unknown, V_S_AFTER] = np.nan
    bent = _bent(data, line, blocks)
    straight = ~np.isin(data.shots, [one.shot for one in bent])
    found = told(data.shots[straight], velocities[straight], covariance[straight], data.bodies)
    return replace(found, left_out=(*bent, *found.left_out))


def _bent(data: PoseData, line: Comparison, blocks: Floats) -> list[LeftOut]:
    """Return the shots whose poses no free flights can be: mis-tracked, by all that can be told."""
    pulled = line.pulled.reshape(len(data.shots), KINDS, -1, 1)
    taken = (np.swapaxes(pulled, 2, 3) @ blocks @ pulled).sum(axis=(1, 2, 3))
    chi2 = line.chi2 - taken
    fitted = (np.diagonal(blocks, axis1=2, axis2=3) > 0).sum(axis=(1, 2))
    freedom = np.maximum(data.measured.sum(axis=(1, 2, 3)) - fitted, 1)
    bad = chi2_distribution.sf(chi2, freedom) < ALARM_SHARE / len(chi2)
    if bad.sum() > PHYSICS_SHARE * len(bad):
        return []
    return [
        LeftOut(
            int(data.shots[row]),
            f"its poses are no free flights: chi-squared {chi2[row]:.0f} for {freedom[row]} "
            "degrees of freedom; look at its frames",
        )
        for row in np.flatnonzero(bad)
    ]


def scalars(numbers: Floats, radii: tuple[float, float]) -> Floats:
    """Return v_n, v_s, v_n', v_s' (thesis, section 7.1) of flights (N, 48), m/s, shape (N, 4).

    Not a number where the spheres pass each other by. Gravity moves both alike, so that relative
    velocities hold at any time.
    """
    parts = numbers.reshape(-1, 2, 2, 2, 2, 3)
    gap = parts[:, 1, 0, 0, 0] - parts[:, 0, 0, 0, 0]
    before, after = (parts[:, 1, 0, side, 1] - parts[:, 0, 0, side, 1] for side in (0, 1))
    normal = _normal(gap, before, sum(radii))
    turning = [radii[0] * parts[:, 0, 1, s, 1] + radii[1] * parts[:, 1, 1, s, 1] for s in (0, 1)]
    incident = _across(before, normal) + np.cross(normal, turning[0])
    leaving = _across(after, normal) + np.cross(normal, turning[1])
    length = np.linalg.norm(incident, axis=1)
    along = incident / np.maximum(length, 1e-12)[:, None]
    return np.stack(
        [
            (before * normal).sum(axis=1),
            np.where(np.isnan(normal[:, 0]), np.nan, length),
            (after * normal).sum(axis=1),
            (leaving * along).sum(axis=1),
        ],
        axis=1,
    )


def _normal(gap: Floats, velocity: Floats, reach: float) -> Floats:
    """Return unit vectors from a to b at first touch (equations 5-34 to 5-37), shape (N, 3)."""
    a = (velocity**2).sum(axis=1)
    b = (gap * velocity).sum(axis=1)
    c = (gap**2).sum(axis=1) - reach**2
    square = b**2 - a * c
    root = np.sqrt(np.where(square >= 0, square, np.nan))
    return np.asarray((gap + velocity * ((-b - root) / a)[:, None]) / reach)


def _across(vectors: Floats, normal: Floats) -> Floats:
    return np.asarray(vectors - (vectors * normal).sum(axis=1, keepdims=True) * normal)


def _numbers(sides: Flights) -> Floats:
    """Return the 48 numbers of the flights; orientations at contact are of no account here, 0."""
    numbers = np.zeros((len(sides.duration), 2, 2, 2, 2, 3))
    numbers[:, :, 0, :, 0], numbers[:, :, 0, :, 1] = sides.place, sides.velocity
    numbers[:, :, 1, :, 1] = sides.spin
    return numbers.reshape(-1, NUMBERS)


def _inverse(gram: Floats) -> Floats:
    """Invert information, shape (S, 4, 12, 12); what was not seen is held, with no error."""
    scale = np.sqrt(np.maximum(np.diagonal(gram, axis1=2, axis2=3), 1e-300))
    values, vectors = np.linalg.eigh(gram / scale[..., :, None] / scale[..., None, :])
    seen = values > LEAST_INFORMATION
    share = np.where(seen, 1.0 / np.where(seen, values, 1.0), 0.0)
    whole = (vectors * share[..., None, :]) @ np.swapaxes(vectors, 2, 3)
    known = scale > 1e-140
    held = known[..., :, None] & known[..., None, :]
    return np.asarray(np.where(held, whole / scale[..., :, None] / scale[..., None, :], 0.0))


def _carried(numbers: Floats, blocks: Floats, radii: tuple[float, float]) -> Floats:
    """Carry the covariance of the flights to the four velocities, shape (S, 4, 4)."""
    sigma = np.sqrt(np.diagonal(blocks, axis1=2, axis2=3)).reshape(len(numbers), NUMBERS)
    slopes = np.zeros((len(numbers), 4, NUMBERS))
    for k in range(NUMBERS):
        step = np.zeros_like(numbers)
        step[:, k] = np.maximum(STEP * sigma[:, k], 1e-9)
        change = scalars(numbers + step, radii) - scalars(numbers - step, radii)
        slopes[:, :, k] = change / (2 * step[:, k : k + 1])
    by_block = slopes.reshape(len(numbers), 4, KINDS, -1).swapaxes(1, 2)
    return np.asarray((by_block @ blocks @ by_block.swapaxes(2, 3)).sum(axis=1))
