"""Impacts of a campaign from its poses: every shot from its own two flights, by itself.

What right after tracking is measured of a shot (`analysis.two_sides`) is measured here of the same
poses: no law, and no scale or outline that other shots have bent. A shot is left out when its poses
are no free flight, never because its impact is unlike the others.

A sphere that bounces has no partner whose outline would say when they touch: the flights before and
after meet in time where the sphere is as deep on both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.collision.coefficients import HELD
from analysis.collision.contact_frames import longest_contact
from analysis.collision.derivative import derivative
from analysis.collision.force_law import stated_modulus
from analysis.collision.impact import ContactState, impact_velocities
from analysis.errors import ShotRefusedError
from analysis.model.data.inside import outside_contact
from analysis.model.data.poses import PoseData
from analysis.motion.drift import WORST_LENGTH, Drift
from analysis.motion.spin import Spin, fit_spin
from analysis.motion.velocity import FlightPath, fit_flight
from analysis.results.impacts import (
    SHARED,
    V_N,
    V_N_AFTER,
    V_S,
    V_S_AFTER,
    Impacts,
    LeftOut,
    measured_impacts,
)
from analysis.scene import Scene
from analysis.shot_poses import NOT_MEASURED_M, ShotPoses
from analysis.two_sides import MOST_FLIGHT_CHI2, TwoSides, measure_two_sides

LEAST_FRAMES = 3
"""Of a flight: a line and one frame that says how far it is one."""
MOST_CHI2 = 8.0
"""Of a flight, per degree of freedom, times what is typical of the campaign where that is more."""
SOFT_CONTACT_S = 5e-4
"""Contacts of balls last 0.05 ms, of hard ones, to 2 ms: so long where no modulus is stated."""
PLACES, SPINS, SCALE, LEANS = slice(0, 12), slice(12, 18), 18, slice(19, 21)
"""Where places and velocities before and after, spins, scale and leans stand among the states."""


@dataclass(frozen=True, slots=True, eq=False)
class Bounce:
    """A bounce of a sphere: v_n, v_s, v_n', v_s' with covariance and shared errors, as `Impacts`.

    `chi2` is that of the places, per degree of freedom, of either flight, and `turn_chi2` that of
    the orientations.
    """

    velocities: Floats
    covariance: Floats
    shared: Floats
    chi2: Floats
    turn_chi2: Floats


def bounce_impacts(data: PoseData, scene: Scene) -> Impacts:
    """Measure every bounce of a campaign from its poses alone.

    Errors that are not stated are taken from the scatter of all bounces about their free flights.
    """
    found = _bounces(data, scene)
    if data.estimated:
        whole = [one for one in found if one is not None]
        places, turns = (
            np.sqrt(_typical(values))
            for values in ([b.chi2 for b in whole], [b.turn_chi2 for b in whole])
        )
        found = _bounces(data.with_noise(places, turns), scene)
    typical = _typical([one.chi2 for one in found if one is not None])
    most = MOST_CHI2 * max(1.0, typical)
    left_out, kept = [], []
    for number, one in zip(data.shots.tolist(), found, strict=True):
        if one is None:
            reason = f"fewer than {LEAST_FRAMES} frames before the contact or after it"
            left_out.append(LeftOut(number, reason))
        elif (one.chi2 > most).any():
            worst = f"chi-squared {one.chi2.max():.0f} per degree of freedom, {most:.3g} allowed"
            left_out.append(LeftOut(number, f"its flights are not free: {worst}"))
        else:
            kept.append((number, one))
    impacts = measured_impacts(
        np.array([number for number, _ in kept], dtype=np.intp),
        np.array([one.velocities for _, one in kept]).reshape(-1, 4),
        np.array([one.covariance for _, one in kept]).reshape(-1, 4, 4),
        data.bodies,
        np.array([one.shared for _, one in kept]).reshape(-1, SHARED, 4),
    )
    return replace(impacts, left_out=(*left_out, *impacts.left_out))


def _bounces(data: PoseData, scene: Scene) -> list[Bounce | None]:
    clear, since = outside_contact(data)
    return [_bounce(clear, since[row], scene, row) for row in range(len(data.shots))]


def _bounce(data: PoseData, since_s: Floats, scene: Scene, row: int) -> Bounce | None:
    """Measure one bounce; None where too few frames show a flight."""
    sides = [np.flatnonzero(data.seen[row] & side) for side in (since_s < 0.0, since_s > 0.0)]
    if min(map(len, sides)) < LEAST_FRAMES:
        return None
    paths, spins = [], list[Spin | None]()
    slow = data.own_slow.get(int(data.shots[row]), data.slow)
    known = np.isfinite(data.position_sigma[row, np.concatenate(sides), 0]).any(axis=0)
    for frames in sides:
        times = since_s[frames]
        # Without spin nothing says how long an error lasts: so long that a speed suffers most.
        lasting = float(np.ptp(times)) / WORST_LENGTH
        sigma = np.where(known, data.position_sigma[row, frames, 0], NOT_MEASURED_M)
        path = fit_flight(
            *(times, np.where(known, data.position[row, frames, 0], 0.0), sigma),
            Drift(slow.position_m, lasting),
            gravity=data.gravity,
            reference_s=0.0,
            drag=scene.drag(0),
        )
        paths.append(path)
        turned = frames[np.isfinite(data.rotation_sigma[row, frames, 0])]
        if len(turned) < LEAST_FRAMES or not known.all():
            spins.append(None)
            continue
        errors = data.rotation_sigma[row, turned, 0, None, None] ** 2 * data.turns[row, turned, 0]
        turns = Drift(slow.rotation_rad, lasting)
        spins.append(fit_spin(since_s[turned], data.rotation[row, turned, 0], errors, turns))
    return _combined(data, paths, spins, slow.scale)


def _combined(
    data: PoseData, paths: Sequence[FlightPath], spins: Sequence[Spin | None], scale_sigma: float
) -> Bounce:
    centre, own = np.zeros(LEANS.stop), np.zeros((LEANS.stop, LEANS.stop))
    centre[SCALE] = 1.0
    common = np.zeros((SHARED, LEANS.stop))
    common[0, SCALE] = scale_sigma
    for k, path in enumerate(paths):
        place = slice(6 * k, 6 * k + 6)
        centre[place] = *path.position, *path.velocity
        own[place, place] = path.covariance
        common[1, place] = path.drag_shift
    for k, spin in enumerate(spins):
        if spin is not None:
            place = slice(SPINS.start + 3 * k, SPINS.start + 3 * k + 3)
            centre[place], own[place, place] = spin.velocity, spin.covariance
    # As all bounces share the scale and the air, they share how the plate leans.
    common[HELD + np.arange(2), LEANS.start + np.arange(2)] = data.plate.sigma_rad
    covariance = own + common.T @ common

    def outcomes(states: Floats) -> Floats:
        return _outcomes(states, paths, data)

    jacobian = derivative(outcomes, centre, np.sqrt(np.diag(covariance)))
    values, spread = outcomes(centre[None])[0], jacobian @ covariance @ jacobian.T
    gone = _while_it_lasts(values, data)
    spread += gone[:, None] * gone
    shared = common @ jacobian.T
    # All contacts of a campaign are as long, nearly: their mean errs as each does.
    shared[-1] = gone
    if any(spin is None for spin in spins):
        unseen = [V_S, V_S_AFTER]
        values[unseen], shared[:, unseen] = np.nan, 0.0
        spread[unseen], spread[:, unseen] = 0.0, 0.0
        spread[unseen, unseen] = 1.0
    turn_chi2 = np.array([np.nan if spin is None else spin.chi2_per_dof for spin in spins])
    return Bounce(values, spread, shared, np.array([p.chi2_per_dof for p in paths]), turn_chi2)


def _outcomes(states: Floats, paths: Sequence[FlightPath], data: PoseData) -> Floats:
    """Return v_n, v_s, v_n', v_s', shape (n, 4), of states of shape (n, 21)."""
    normal = np.array(data.plate.normal)
    along = np.linalg.svd(normal[None])[2][1:]
    normal = normal + states[:, LEANS] @ along
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    scaled = states[:, SCALE, None, None, None] * states[:, PLACES].reshape(-1, 2, 2, 3)
    depth = (scaled * normal[:, None, None]).sum(axis=3)
    apart, leaving = (depth[:, 1] - depth[:, 0]).T
    wait = -(apart / leaving)[:, None]
    before, after = (scaled[:, k, 1] + paths[k].acceleration * wait for k in (0, 1))
    still, spin = np.zeros_like(before), states[:, SPINS].reshape(-1, 2, 3)
    v = impact_velocities(
        ContactState(before, still, spin[:, 0], still),
        ContactState(after, still, spin[:, 1], still),
        normal,
        (data.bodies[0].radius, 0.0),
    )
    return np.stack([v.v_n, v.v_s, v.v_n_after, v.v_s_after], axis=1)


def _while_it_lasts(velocities: Floats, data: PoseData) -> Floats:
    """Return what gravity may add to the speeds while the contact lasts, m/s, shape (4,).

    The flights meet e / (1 + e) of the contact after first touch. Nobody states how long it is: an
    error at its full size, and nothing is taken out.
    """
    came, left = abs(velocities[V_N]), abs(velocities[V_N_AFTER])
    lasts_s = float(longest_contact(came, data.bodies))
    if stated_modulus(data.bodies) is None:
        lasts_s = max(lasts_s, SOFT_CONTACT_S)
    added = data.gravity * data.plate.normal[0] * lasts_s
    gone = np.zeros(4)
    gone[V_N], gone[V_N_AFTER] = (added * share / (came + left) for share in (left, -came))
    return gone


def pose_impacts(data: PoseData) -> Impacts:
    """Measure the impact of every shot from its poses alone.

    Errors that are not stated are taken from the scatter of all shots about their free flights.
    Where stated ones are too small throughout, the limit for a bent track is enlarged as much.
    """
    scene = scene_of(data)
    if data.on_plate:
        return bounce_impacts(data, scene)
    scenes = [replace(scene, slow=data.own_slow.get(int(n), data.slow)) for n in data.shots]

    def measured(given: PoseData) -> list[TwoSides | ShotRefusedError]:
        pairs = zip(_each(given), scenes, strict=True)
        return [_measured(poses, own, np.inf) for poses, own in pairs]

    first = measured(data)
    whole = [one for one in first if isinstance(one, TwoSides)]
    tracks = _typical([one.flight_chi2 for one in whole])
    if data.estimated:
        turns = _typical([one.spin_chi2 for one in whole])
        data = data.with_sigmas(
            np.sqrt(tracks) * data.position_sigma, np.sqrt(turns) * data.rotation_sigma
        )
        first, tracks = measured(data), 1.0
    most = MOST_FLIGHT_CHI2 * max(1.0, tracks)
    # The limit changes no number: only shots beyond it are measured again, for the reason.
    found = [
        _measured(poses, own, most)
        if isinstance(one, TwoSides) and (one.flight_chi2 > most).any()
        else one
        for one, poses, own in zip(first, _each(data), scenes, strict=True)
    ]
    return _impacts(data, found)


def scene_of(data: PoseData) -> Scene:
    """Return bodies and surroundings of a campaign of poses."""
    return Scene(
        bodies=data.bodies,
        gravity=data.gravity,
        air_density=data.air_density,
        drag_coefficient=data.drag_of_flights,
        drag_sigma=data.drag_sigma,
        # Poses without a stated exposure are those of instants.
        exposure_s=data.camera.exposure_s or 0.0,
        slow=data.slow,
    )


def _each(data: PoseData) -> Iterator[ShotPoses]:
    """Return the poses of each shot, without the frames that only fill it up."""
    for row in range(len(data.shots)):
        shown = np.flatnonzero(data.measured[row].any(axis=(1, 2)))
        yield ShotPoses(
            frames=shown,
            times_s=data.times_s[row, shown],
            position=data.position[row, shown],
            position_sigma=data.position_sigma[row, shown],
            rotation=data.rotation[row, shown],
            rotation_sigma=data.rotation_sigma[row, shown],
            turn_shape=data.turns[row, shown],
        )


def _measured(poses: ShotPoses, scene: Scene, most_chi2: float) -> TwoSides | ShotRefusedError:
    try:
        return measure_two_sides(poses, scene, most_chi2=most_chi2)
    except ShotRefusedError as refusal:
        return refusal


def _typical(chi2: Sequence[Floats]) -> float:
    """Return the median chi-squared per degree of freedom, 1 without any."""
    every = np.concatenate([np.empty(0), *chi2])
    every = every[np.isfinite(every)]
    return float(np.median(every)) if every.size else 1.0


def _impacts(data: PoseData, found: list[TwoSides | ShotRefusedError]) -> Impacts:
    shots = len(found)
    velocities = np.full((shots, 4), np.nan)
    covariance, shared = np.tile(np.eye(4), (shots, 1, 1)), np.zeros((shots, SHARED, 4))
    left_out = []
    for row, one in enumerate(found):
        if isinstance(one, ShotRefusedError):
            left_out.append(LeftOut(int(data.shots[row]), one.reason))
            continue
        impact = one.impact
        covariance[row], shared[row] = impact.covariance, impact.shared
        velocities[row, [V_N, V_N_AFTER]] = impact.v_n.value, impact.v_n_after.value
        if impact.v_s is not None and impact.v_s_after is not None:
            velocities[row, [V_S, V_S_AFTER]] = impact.v_s.value, impact.v_s_after.value
    measured = ~np.isin(data.shots, [one.shot for one in left_out])
    impacts = measured_impacts(
        data.shots[measured],
        velocities[measured],
        covariance[measured],
        data.bodies,
        shared[measured],
    )
    return replace(impacts, left_out=(*left_out, *impacts.left_out))
