"""Flights after a contact whose heights the mirror's view does not show, or in one frame only.

What flies off toward the camera or away from it leaves the mirror's view within a frame or two, and
a small sphere may fly before a large one or behind it. Its height is known all the same where both
are seen before the contact: no sphere jumps in the microseconds that a contact lasts, so that one
height more gives its velocity, and without any the other sphere's does, as the contact changes the
momentum of the pair by nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.errors import ShotRefusedError
from analysis.motion.velocity import FlightPath

Placed = tuple[Floats, Floats, Floats]
"""Times, s, shape (n,), centres and their standard errors, m, shape (n, 3), infinite where a
coordinate is not seen."""
Fit = Callable[[int, Placed], FlightPath]
"""Of sphere 0 or 1 to its places; the path refers to the contact."""

Z, V_Z = 2, 5
"""Of a path's position and velocity."""
LEAST_HEIGHTS = 2
SOON, EXACT_M = 0.1, 1e-9
"""Steps between frames after which a height by momentum holds (air slows it by nothing there), and
the error that a fit is given for it: what is true of it is stated afterwards."""
MOST_SIGMAS, MOST_SHARE = 5.0, 0.05
"""Momentum that two spheres seem to gain across the front view: in its errors, and over that which
they bring."""


def paths_after(
    before: tuple[FlightPath, FlightPath],
    after: tuple[Placed, Placed],
    masses: tuple[float, float],
    slow: tuple[float, float],
    fit: Fit,
) -> tuple[tuple[FlightPath, FlightPath], tuple[str, ...]]:
    """Return both paths after contact, and by what those have their height that lack heights.

    Parameters
    ----------
    before
        Paths that refer to the first touch.
    after
        Places of a and b. Two heights are seen, of one of them or of each: one alone nothing would
        bear out.
    masses
        Of a and b, kg.
    slow
        Part of the standard error of a height that is the same before and after contact, m, and
        standard error of the time of first touch, s.

    Raises
    ------
    ShotRefusedError
        A lone height does not keep the momentum of the pair: it is something else's.
    """
    seen = [int(np.isfinite(own[2][:, Z]).sum()) for own in after]
    placed = [
        _from_contact(own, path, *slow) if count == 1 else own
        for own, path, count in zip(after, before, seen, strict=True)
    ]
    found = {i: fit(i, placed[i]) for i in (0, 1) if seen[i]}
    notes = []
    for i, count in enumerate(seen):
        if count >= LEAST_HEIGHTS:
            continue
        other = found[1 - i]
        kept = masses[1 - i] / masses[i]
        told = f"the top view shows sphere {'ab'[i]} in {count} of the {len(after[i][0])} frames "
        if count == 0:
            found[i] = _by_momentum(after[i], before[i], (before[1 - i], other), kept, (i, fit))
            by = "its velocity in depth is that which keeps the momentum of both"
        else:
            _check_momentum(found[i], before[i], (before[1 - i], other), kept, told)
            by = "its velocity in depth is counted from where it was at the contact"
        notes.append(f"{told}after the contact: {by}")
    return (found[0], found[1]), tuple(notes)


def _from_contact(placed: Placed, before: FlightPath, slow_m: float, touch_s: float) -> Placed:
    """Add the height at first touch as one that was seen."""
    times_s, positions, sigmas = placed
    seen = int(np.isfinite(sigmas[:, Z]).argmax())
    own, height = sigmas[seen, Z], before.position[Z]
    quick = math.sqrt(max(before.covariance[Z, Z] - slow_m**2, 0.0))
    # Where the touch comes later the sphere was there later, and left it faster.
    left = (positions[seen, Z] - height) / (times_s[seen] - before.reference_s)
    place, sigma = np.array([0.0, 0.0, height]), np.full(3, np.inf)
    sigma[Z] = math.hypot(max(quick, own), (left - before.velocity[Z]) * touch_s)
    return (
        np.concatenate([[before.reference_s], times_s]),
        np.concatenate([place[None], positions]),
        np.concatenate([sigma[None], sigmas]),
    )


def _velocity_kept(
    before: FlightPath, other: tuple[FlightPath, FlightPath], ratio: float
) -> tuple[float, float]:
    """Return the velocity in depth that keeps the momentum, m/s, and its variance.

    Parameters
    ----------
    other
        Paths of the other sphere before and after contact.
    ratio
        Its mass over this one's.
    """
    came, left = other
    velocity = before.velocity[Z] + ratio * (came.velocity[Z] - left.velocity[Z])
    spread = before.covariance[V_Z, V_Z]
    spread += ratio**2 * (came.covariance[V_Z, V_Z] + left.covariance[V_Z, V_Z])
    return float(velocity), float(spread)


def _by_momentum(
    placed: Placed,
    before: FlightPath,
    other: tuple[FlightPath, FlightPath],
    ratio: float,
    whose: tuple[int, Fit],
) -> FlightPath:
    """Fit a path without heights, its velocity in depth from the momentum of both."""
    velocity, variance = _velocity_kept(before, other, ratio)
    sphere, fit = whose
    times_s, positions, sigmas = placed
    soon = SOON * float(np.median(np.diff(times_s)))
    places, errors = np.zeros((2, 3)), np.full((2, 3), np.inf)
    places[:, Z] = before.position[Z] + np.array([0.0, velocity * soon])
    errors[:, Z] = EXACT_M
    start = before.reference_s
    path = fit(
        sphere,
        (
            np.concatenate([[start, start + soon], times_s]),
            np.concatenate([places, positions]),
            np.concatenate([errors, sigmas]),
        ),
    )
    covariance, shift = path.covariance.copy(), path.drag_shift.copy()
    covariance[Z], covariance[:, Z] = before.covariance[Z], before.covariance[:, Z]
    covariance[V_Z], covariance[:, V_Z] = 0.0, 0.0
    covariance[Z, V_Z] = covariance[V_Z, Z] = 0.0
    covariance[V_Z, V_Z] = variance
    came, left = other
    shift[Z] = before.drag_shift[Z]
    shift[V_Z] = before.drag_shift[V_Z] + ratio * (came.drag_shift[V_Z] - left.drag_shift[V_Z])
    return replace(path, covariance=covariance, drag_shift=shift)


def _check_momentum(
    path: FlightPath,
    before: FlightPath,
    other: tuple[FlightPath, FlightPath],
    ratio: float,
    told: str,
) -> None:
    """Refuse a velocity by a lone height that does not keep the momentum of the pair."""
    velocity, variance = _velocity_kept(before, other, ratio)
    off = abs(float(path.velocity[Z]) - velocity)
    brought = float(np.linalg.norm(before.velocity - other[0].velocity)) * ratio / (1.0 + ratio)
    allowed = MOST_SIGMAS * math.sqrt(variance + path.covariance[V_Z, V_Z])
    allowed = max(allowed, MOST_SHARE * brought)
    if off > allowed:
        raise ShotRefusedError(
            "outlines",
            f"{told}after the contact, which gives it a velocity in depth that is {off:.3f} m/s "
            f"off the one that keeps the momentum of both, {allowed:.3f} m/s are allowed: what the "
            "top view shows there may be something else; look at the film, and see that the top "
            "view shows both spheres in two frames after the contact",
        )
