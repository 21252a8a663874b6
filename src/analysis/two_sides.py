"""Motion before and after the contact, and the impact between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.collision.coefficients import (
    Impact,
    Motion,
    NoTouchError,
    first_touch,
    measure_impact,
)
from analysis.errors import ShotRefusedError
from analysis.imaging.views import View
from analysis.motion.drift import Drift, centre_drift, memory, turn_drift
from analysis.motion.pattern import Orientations
from analysis.motion.poses import Centres
from analysis.motion.rotation import rotation_vector
from analysis.motion.spin import fit_spin, three_frame_spin
from analysis.motion.split import LEAST_FRAMES, split_at_contact
from analysis.motion.velocity import FlightPath, fit_flight, three_frame_flight
from analysis.setup import Setup
from analysis.tracking import Tracking

Floats = NDArray[np.float64]
Frames = NDArray[np.intp]

LONGEST_CONTACT_S = 0.25e-3
"""Nylon spheres of an inch touch for 0.12 to 0.25 ms; frames in that time show neither side."""
THESIS_INTERVAL_S = 2e-3
MISMATCH_FRAMES = 1.5
LEAST_FROM_ABOVE = 2
MOST_FLIGHT_CHI2 = 8.0
"""Of a track's fit, slow errors allowed for; sound shots stay below 1.5."""
IMPOSSIBLE_SIGMAS, LEAST_BEYOND = 5.0, 0.02
DRAG_COEFFICIENT = 0.4
"""Of a smooth sphere at Reynolds numbers of 1e3 to 1e5 (L. Schiller and A. Naumann, 1935)."""


@dataclass(frozen=True, slots=True, eq=False)
class TwoSides:
    """The impact, the frames on either side that it rests on, and those that show neither."""

    impact: Impact
    used_before: tuple[int, ...]
    used_after: tuple[int, ...]
    between: tuple[int, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Sphere:
    """Poses of one sphere with their slow errors; by what share air slows it on a metre of way."""

    name: str
    centres: Centres
    orientations: Orientations
    centre_drift: Drift
    turn_drift: Drift
    drag_per_m: float


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """Clear frames on one side of the contact; `nearest` is the thesis's frame next to it."""

    word: str
    frames: Frames
    times_s: Floats
    nearest: int


def measure_two_sides(
    tracking: Tracking, times_s: Floats, setup: Setup, three_and_three: bool
) -> TwoSides:
    """Fit both sides of the contact and combine them.

    Raises
    ------
    ShotRefusedError
        No contact in the frames, too few frames on a side, or paths that do not meet.
    """
    radii = (setup.spheres[0].diameter_m / 2, setup.spheres[1].diameter_m / 2)
    spheres = [_sphere(tracking, i, times_s, setup) for i in (0, 1)]
    split = split_at_contact(*tracking.centres, times_s, setup.gravity_m_per_s2)
    common = np.intersect1d(tracking.centres[0].frames, tracking.centres[1].frames)
    before, after = common[common < split], common[common >= split]
    contact = _contact_time(spheres, before, times_s, setup, radii)
    _check_between(contact, before, after, times_s)
    half_open = setup.camera.longest_exposure_s / 2
    before = before[times_s[before] < contact - half_open]
    after = after[times_s[after] > contact + LONGEST_CONTACT_S + half_open]
    between = np.setdiff1d(common, np.concatenate([before, after]))
    notes = _left_out(between, tracking, setup)
    if three_and_three:
        before, after = _three(before[::-1], times_s)[::-1], _three(after, times_s)
    sides = _Side("before", before, times_s, -1), _Side("after", after, times_s, 0)
    for side in sides:
        _check_enough(side, split)
        for sphere in spheres:
            _check_seen_from_above(sphere, side)
    motions = [
        _thesis_motion(sphere, sides, contact)
        if three_and_three
        else _fitted_motion(sphere, sides, contact, setup.gravity_m_per_s2)
        for sphere in spheres
    ]
    for sphere, motion in zip(spheres, motions, strict=True):
        for side, path in zip(sides, (motion.before, motion.after), strict=True):
            _check_free_flight(sphere, side, path)
    try:
        impact = measure_impact(motions[0], motions[1], radii, tracking.scale_sigma)
    except NoTouchError as miss:
        raise _never_meet(miss, radii) from miss
    _check_possible(impact)
    used_before, used_after, left_out = (tuple(map(int, k)) for k in (before, after, between))
    return TwoSides(impact, used_before, used_after, left_out, notes)


def _sphere(tracking: Tracking, i: int, times_s: Floats, setup: Setup) -> _Sphere:
    """Gather a sphere's poses and the slow errors that its spin and markers give them."""
    orientations = tracking.orientations[i]
    turns = rotation_vector(
        orientations.rotation[1:] @ orientations.rotation[:-1].transpose(0, 2, 1)
    )
    rates = np.linalg.norm(turns, axis=1) / np.diff(times_s[orientations.frames])
    # Without two orientations there is no rate; the shot is refused when its spin is asked for.
    rate = float(np.median(rates)) if rates.size else 0.0
    lasting = memory(tracking.marker_angle, rate)
    sigma_px, view = tracking.filter_sigma_px, View.FRONT
    body = setup.spheres[i]
    # rho/2 c A v^2 over the mass of a solid sphere.
    drag = 0.75 * DRAG_COEFFICIENT * setup.air_density_kg_per_m3
    return _Sphere(
        name="ab"[i],
        centres=tracking.centres[i],
        orientations=orientations,
        centre_drift=centre_drift(sigma_px, tracking.scales_px_per_m[view], lasting),
        turn_drift=turn_drift(sigma_px, tracking.radii[view][i], lasting),
        drag_per_m=drag / (body.density_kg_per_m3 * body.diameter_m),
    )


def _contact_time(
    spheres: list[_Sphere],
    before: Frames,
    times_s: Floats,
    setup: Setup,
    radii: tuple[float, float],
) -> float:
    reference, gravity = float(times_s[before[-1]]), setup.gravity_m_per_s2
    side = _Side("before", before, times_s, -1)
    for sphere in spheres:
        _check_seen_from_above(sphere, side)
    paths = [_flight(sphere, side, reference, gravity) for sphere in spheres]
    try:
        return first_touch(paths[0], paths[1], radii)
    except NoTouchError as miss:
        raise _never_meet(miss, radii) from miss


def _never_meet(miss: NoTouchError, radii: tuple[float, float]) -> ShotRefusedError:
    return ShotRefusedError(
        "contact",
        f"the paths before the kink pass at {1e3 * miss.closest_m:.2f} mm between the centres; "
        f"the spheres touch at {1e3 * sum(radii):.2f} mm",
    )


def _check_between(contact: float, before: Frames, after: Frames, times_s: Floats) -> None:
    """Refuse where the touch lies far from the kink: then one of the two is wrong."""
    step = float(np.median(np.diff(times_s)))
    early = times_s[before[-1]] - MISMATCH_FRAMES * step
    late = times_s[after[0]] + MISMATCH_FRAMES * step
    if not early <= contact <= late:
        raise ShotRefusedError(
            "contact",
            f"the paths touch at {1e3 * contact:.2f} ms but have their kink between "
            f"{1e3 * times_s[before[-1]]:.2f} and {1e3 * times_s[after[0]]:.2f} ms; check the "
            "diameters and the scale",
            int(after[0]),
        )


def _check_enough(side: _Side, split: int) -> None:
    if side.frames.size < LEAST_FRAMES:
        raise ShotRefusedError(
            "contact",
            f"{side.frames.size} frames clear of the contact {side.word} it; {LEAST_FRAMES} are "
            "needed",
            split,
        )


def _check_seen_from_above(sphere: _Sphere, side: _Side) -> None:
    _, sigma = _placed(sphere, side)
    seen = int(np.isfinite(sigma[:, 2]).sum())
    if seen < LEAST_FROM_ABOVE:
        raise ShotRefusedError(
            "outlines",
            f"the top view shows sphere {sphere.name} in {seen} of the {side.frames.size} frames "
            f"{side.word} the contact; {LEAST_FROM_ABOVE} are needed for its depth",
            int(side.frames[0]),
        )


def _check_free_flight(sphere: _Sphere, side: _Side, path: FlightPath) -> None:
    """Refuse a track that jumps: a frame is lost, repeated or out of order, or the disc was."""
    if not path.chi2_per_dof > MOST_FLIGHT_CHI2:
        return
    times = side.times_s[side.frames]
    position, sigma = _placed(sphere, side)
    fitted = np.array([path.at(float(t))[0] for t in times])
    off = np.where(np.isfinite(sigma), np.abs(position - fitted) / sigma, 0.0).max(axis=1)
    worst = int(off.argmax())
    raise ShotRefusedError(
        "motion",
        f"the track of sphere {sphere.name} {side.word} the contact is no free flight: "
        f"chi-squared {path.chi2_per_dof:.0f} per degree of freedom, {MOST_FLIGHT_CHI2:g} allowed; "
        "look for lost, repeated or exchanged frames",
        int(side.frames[worst]),
    )


def _check_possible(impact: Impact) -> None:
    """Refuse what no passive contact can do: gain energy along or across the normal."""
    ratios = [("e", impact.e, 0.0), ("beta", impact.beta, -1.0)]
    for name, ratio, least in ratios:
        if ratio is None:
            continue
        beyond = max(ratio.value - 1.0, least - ratio.value)
        if beyond > max(IMPOSSIBLE_SIGMAS * ratio.sigma, LEAST_BEYOND):
            raise ShotRefusedError(
                "contact",
                f"{name} = {ratio.concise()} lies outside {least:g} to 1, which no contact can; "
                "check the order of the frames and the orientation of the images",
            )


def _left_out(frames: Frames, tracking: Tracking, setup: Setup) -> tuple[str, ...]:
    sure = setup.camera.exposure_s is not None
    why = "exposed" if sure else "perhaps exposed, as no exposure is stated,"
    notes = [f"frame {k} left out: {why} during the contact" for k in frames]
    for name, sphere in zip("ab", tracking.spheres, strict=True):
        for view, track in sphere.items():
            followed = range(min(track.outlines), max(track.outlines) + 1)
            gaps = [k for k in followed if k not in track.outlines]
            notes += [
                f"frame {k} shows no outline of sphere {name} in the {view.value} view"
                for k in gaps
            ]
    for name, orientations in zip("ab", tracking.orientations, strict=True):
        for k, reason in sorted(orientations.left_out.items()):
            notes.append(f"frame {k} has no orientation of sphere {name}: {reason}")
    return tuple(notes)


def _three(frames: Frames, times_s: Floats) -> Frames:
    """Choose three frames 2 ms apart, beginning with the first given."""
    chosen = list(frames[:1])
    for k in frames[1:]:
        gap = abs(times_s[k] - times_s[chosen[-1]])
        if gap >= THESIS_INTERVAL_S * (1 - 1e-3) and len(chosen) < LEAST_FRAMES:
            chosen.append(k)
    return np.array(chosen, dtype=np.intp)


def _fitted_motion(
    sphere: _Sphere, sides: tuple[_Side, _Side], contact: float, gravity: float
) -> Motion:
    """Fit all frames of both sides by least squares."""
    paths = [_flight(sphere, side, contact, gravity) for side in sides]
    spins = [fit_spin(*_turning(sphere, side, needed=2), sphere.turn_drift) for side in sides]
    return Motion(paths[0], paths[1], spins[0], spins[1])


def _thesis_motion(sphere: _Sphere, sides: tuple[_Side, _Side], contact: float) -> Motion:
    """Take three frames on each side, with an acceleration of their own instead of gravity."""
    paths, spins = [], []
    for side in sides:
        times = side.times_s[side.frames]
        position, sigma = _placed(sphere, side)
        path = three_frame_flight(times, position, sigma, sphere.centre_drift, side.nearest)
        paths.append(path.moved_to(contact))
        turning = _turning(sphere, side, needed=LEAST_FRAMES)
        spins.append(three_frame_spin(*turning, sphere.turn_drift, side.nearest))
    return Motion(paths[0], paths[1], spins[0], spins[1])


def _flight(sphere: _Sphere, side: _Side, reference: float, gravity: float) -> FlightPath:
    position, sigma = _placed(sphere, side)
    return fit_flight(
        side.times_s[side.frames],
        position,
        sigma,
        sphere.centre_drift,
        gravity=gravity,
        reference_s=reference,
        drag_per_m=sphere.drag_per_m,
    )


def _placed(sphere: _Sphere, side: _Side) -> tuple[Floats, Floats]:
    index = np.searchsorted(sphere.centres.frames, side.frames)
    return sphere.centres.position[index], sphere.centres.sigma[index]


def _turning(sphere: _Sphere, side: _Side, needed: int) -> tuple[Floats, Floats, Floats]:
    """Return times, orientations and covariances of the frames of a side that have them.

    Raises
    ------
    ShotRefusedError
        Fewer than `needed` do.
    """
    orientations = sphere.orientations
    index = np.flatnonzero(np.isin(orientations.frames, side.frames))
    if index.size < needed:
        raise ShotRefusedError(
            "rotation",
            f"sphere {sphere.name} has an orientation in {index.size} of the {side.frames.size} "
            f"frames {side.word} the contact; {needed} are needed",
            int(side.frames[0]),
        )
    times = side.times_s[orientations.frames[index]]
    return times, orientations.rotation[index], orientations.covariance[index]
