"""How large the slow errors of a campaign's poses are, from the scatter of its own flights.

About a free flight, poses scatter by the noise of their pixels, fresh in every frame, and by what
shading and pattern leave, which lasts while the same markers are seen (`motion.drift`). Straight
lines, a drag of the air and a constant spin are taken out of each flight before and after contact,
and what is left is turned to independent numbers, the slow part of each with a known gain
(restricted maximum likelihood: H. D. Patterson and R. Thompson, Biometrika 58, 545 (1971)). No law
of contact enters.

Few frames say little: beside a flight of ten frames a slow error as large as half of the fresh one
stays unseen. A prior holds what the renderers of others have shown.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.errors import ShotRefusedError
from analysis.motion.cutting import cut_tears
from analysis.motion.drift import TURN_PER_CENTRE_ERROR, Drift, correlation_time
from analysis.motion.pattern import Orientations
from analysis.motion.poses import Centres
from analysis.motion.rotation import rotation_vector
from analysis.motion.slow_evidence import Evidence, slow_size
from analysis.motion.spin import fit_spin
from analysis.motion.split import split_at_contact
from analysis.motion.turning import turn_slopes, turned
from analysis.motion.velocity import DOWN
from analysis.photometric.birge_ratio import birge_ratios
from analysis.photometric.follow.film import Film
from analysis.photometric.learn.appearance import (
    LONE_SHARED_PX,
    PRIOR_SLOW_PX,
    SHARED_PX,
    Appearance,
)
from analysis.photometric.result import centres_of, markers_of, orientations_of

Side = tuple[int, int]

NO_DRIFT = Drift(0.0, 1.0)
LEAST_FRAMES = 6
PATTERN_SHARE = 0.7
"""Of the error of a marker's place, in the slow error of one view, which shows three or four at a
time. It lasts while a sphere turns by a radian, longer than what is seen of it beside a free flight
(docs/decisions/0061-patterns-seen-in-one-view.md)."""
STEADY = 1e-9
"""Of the largest direction of what was fitted, below which a direction is none of it."""


def sized(films: Sequence[Film], known: Appearance) -> Appearance:
    """Return an appearance with the slow error that films measured with it show."""
    seen = [own for film in films if (own := _film_evidence(film, known)) is not None]
    coarse = (1.0 + known.coarseness) / 2
    by_pattern = 0.0
    if len(known.camera.views) == 1:
        radius_px = float(known.camera.optics.scales[0]) * known.spheres[0].radius_m
        by_pattern = PATTERN_SHARE * known.pattern_sigma_rad * radius_px
    return replace(
        known,
        films=len(films),
        slow_px=float(np.hypot(slow_size_px(seen, coarse * PRIOR_SLOW_PX), by_pattern)),
        shared_px=coarse * shared_size_px(len(films)),
    )


def shared_size_px(films: int) -> float:
    """Return what all flights share where so many films taught, px."""
    return max(SHARED_PX, LONE_SHARED_PX / max(films, 1))


def slow_size_px(films: Sequence[Evidence], prior_px: float = PRIOR_SLOW_PX) -> float:
    """Return how large the slow error of an outline's place is, px, from evidence in 1/px^2."""
    return slow_size(films, prior_px)


def _film_evidence(film: Film, known: Appearance) -> Evidence | None:
    """Return what a film says, its errors enlarged as they will be stated; None without flights."""
    touch_m = sum(sphere.radius_m for sphere in known.spheres)
    places = centres_of(film, known, 0), centres_of(film, known, 1)
    clock = film.times_s, film.gravity
    try:
        off = cut_tears(places, *clock, touch_m)
        places = _without(places[0], off[0]), _without(places[1], off[1])
        split = split_at_contact(*places, *clock)
    except ShotRefusedError:
        return None
    c, d = (orientations_of(film, known, i, markers_of(film, known, i)) for i in (0, 1))
    turns = c, d
    place, turn = birge_ratios(places, turns, *clock)
    a, b = (replace(own, sigma=np.sqrt(place) * own.sigma) for own in places)
    c, d = (replace(own, covariance=turn * own.covariance) for own in turns)
    scale, sphere = float(known.camera.optics.scales[0]), known.spheres[0]
    # The frames next to the contact may hold both motions.
    sides = ((0, split - 1), (split + 1, len(film.times_s)))
    outline = scale, scale * sphere.radius_m, sphere.alpha
    return evidence_of((a, b), (c, d), clock, sides, outline)


def _without(own: Centres, frames: Mapping[int, str]) -> Centres:
    kept = ~np.isin(own.frames, list(frames))
    return Centres(own.frames[kept], own.position[kept], own.sigma[kept])


def evidence_of(
    centres: tuple[Centres, Centres],
    orientations: tuple[Orientations, Orientations],
    clock: tuple[Floats, float],
    sides: Sequence[Side],
    outline: tuple[float, float, float],
) -> Evidence:
    """Return what one film says of its slow errors.

    Parameters
    ----------
    centres, orientations
        Of a and b, of frames that belong to free flights, with the errors that are stated of them.
    clock
        Times of all frames, s, shape (F,), and gravity along +X, m/s^2.
    sides
        Half-open ranges of frames before and after the contact.
    outline
        Scale, px/m, radius, px, and angular radius of the markers, rad.
    """
    (times_s, gravity), (scale, radius, alpha) = clock, outline
    gains, squares = [np.empty(0)], [np.empty(0)]
    for place, turn in zip(centres, orientations, strict=True):
        lasting_s = correlation_time(alpha, _rate(turn, times_s))
        for first, last in sides:
            for parts in (
                _places(place, (first, last), times_s, gravity, Drift(1 / scale, lasting_s)),
                _turns(
                    turn, (first, last), times_s, Drift(TURN_PER_CENTRE_ERROR / radius, lasting_s)
                ),
            ):
                gains.append(parts[0])
                squares.append(parts[1])
    return Evidence(np.concatenate(gains), np.concatenate(squares))


def _rate(turn: Orientations, times_s: Floats) -> float:
    steps = rotation_vector(turn.rotation[1:] @ turn.rotation[:-1].swapaxes(1, 2))
    rates = np.linalg.norm(steps, axis=1) / np.diff(times_s[turn.frames])
    return float(np.median(rates)) if rates.size else 0.0


def _places(
    own: Centres, side: Side, times_s: Floats, gravity: float, unit: Drift
) -> tuple[Floats, Floats]:
    """Return gains and squares of a flight: lines and drag taken out of its coordinates."""
    chosen = (own.frames >= side[0]) & (own.frames < side[1])
    times, sigma = times_s[own.frames[chosen]], own.sigma[chosen]
    seen = np.isfinite(sigma)
    # Without a mirror Z is a constant, and no measurement.
    seen &= (seen.sum(axis=0) >= LEAST_FRAMES) & own.position[chosen].any(axis=0)
    if not seen.any():
        return np.empty(0), np.empty(0)
    tau = times - times.mean()
    straight = own.position[chosen] - 0.5 * gravity * DOWN * tau[:, None] ** 2
    speeds = np.zeros(3)
    for k in np.flatnonzero(seen.any(axis=0)):
        speeds[k] = np.polyfit(tau[seen[:, k]], straight[seen[:, k], k], 1)[0]
    bends = np.linalg.norm(speeds) * speeds * tau[:, None] ** 2
    lines = _each_axis(np.stack([np.ones_like(tau), tau], axis=1))
    flat = seen.ravel()
    design = np.concatenate([lines, bends.reshape(-1, 1)], axis=1)
    return _independent(
        straight.ravel()[flat],
        design[flat],
        sigma.ravel()[flat],
        _each_axis(unit.covariance(times))[np.ix_(flat, flat)],
    )


def _turns(own: Orientations, side: Side, times_s: Floats, unit: Drift) -> tuple[Floats, Floats]:
    """Return gains and squares of the turns of a flight about its constant spin."""
    chosen = (own.frames >= side[0]) & (own.frames < side[1])
    if chosen.sum() < LEAST_FRAMES:
        return np.empty(0), np.empty(0)
    times, rotation = times_s[own.frames[chosen]], own.rotation[chosen]
    covariance = own.covariance[chosen]
    spin = fit_spin(times, rotation, covariance, NO_DRIFT).velocity
    tau = times - times.mean()
    middle = int(np.abs(tau).argmin())
    expected = np.array([turned(spin * (t - tau[middle]), rotation[middle]) for t in tau])
    left = rotation_vector(rotation @ expected.swapaxes(1, 2))
    return _independent(
        left.ravel(),
        np.concatenate([turn_slopes(spin, t - tau[middle]) for t in tau]),
        np.sqrt(np.einsum("nii->ni", covariance)).ravel(),
        _each_axis(unit.covariance(times)),
    )


def _each_axis(columns: Floats) -> Floats:
    """Return a matrix (n, k) for three axes, shape (3 n, 3 k)."""
    return np.asarray(np.kron(columns, np.eye(3)), dtype=np.float64)


def _independent(
    values: Floats, design: Floats, sigma: Floats, slow: Floats
) -> tuple[Floats, Floats]:
    """Return gains and squares of what the columns of a design leave of values, shapes (n - k,).

    A column without entries, as for an axis that nobody measured, takes nothing.
    """
    design = design[:, design.any(axis=0)]
    vectors, sizes, _ = np.linalg.svd(design / (sigma[:, None] * np.linalg.norm(design, axis=0)))
    rest = vectors[:, int((sizes > STEADY * sizes[0]).sum()) :]
    gains, turn = np.linalg.eigh(rest.T @ (slow / np.outer(sigma, sigma)) @ rest)
    return np.maximum(gains, 0.0), np.asarray((turn.T @ (rest.T @ (values / sigma))) ** 2)
