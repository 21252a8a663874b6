"""The impact of one shot, measured from its own poses: two free flights of each sphere, no law.

The same poses give the same impact on every way: right after tracking, from poses.csv, from stored
results (docs/decisions/0021). The scale and the outlines stay as they were calibrated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.coefficients import (
    Impact,
    Motion,
    first_touch,
    measure_impact,
    touch_with_error,
)
from analysis.collision.contact_frames import inside_contact
from analysis.collision.instant import NoTouchError
from analysis.collision.spin_balance import contradicted
from analysis.errors import ShotRefusedError
from analysis.motion.cutting import cut_tears
from analysis.motion.drift import Drift, correlation_time
from analysis.motion.rotation import rotation_vector
from analysis.motion.spin import Spin, fit_spin, three_frame_spin
from analysis.motion.split import LEAST_FRAMES, split_at_contact
from analysis.motion.tears import LEAST_IN_ONE_VIEW, LEAST_TOGETHER, agreeing_turns
from analysis.motion.unseen_heights import paths_after
from analysis.motion.velocity import NO_DRAG, FlightPath, fit_flight, three_frame_flight
from analysis.refusals import (
    check_between,
    check_enough,
    check_free_flight,
    check_opposite,
    check_parting,
    check_possible,
    check_seen,
    never_meet,
)
from analysis.scene import Scene
from analysis.shot_poses import Frames, ShotPoses
from analysis.sides import Side

THESIS_INTERVAL_S = 2e-3
LEAST_TURNS = 2
LEAST_SHOWN = 2
"""Heights after contact, of one sphere or of both: the others follow (`unseen_heights`)."""
MOST_FLIGHT_CHI2 = 8.0
"""Of a track's fit, slow errors allowed for; sound shots stay below 1.5."""
NO_MEMORY = Drift(0.0, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class TwoSides:
    """The impact, and the frames that it rests on.

    Attributes
    ----------
    used_before, used_after
        Numbers of the frames on either side of the contact.
    between
        Those that may show part of the contact, and so neither side.
    wild
        Sphere, a or b, and number of frames that lie off its free flight.
    astray
        Sphere and number of frames whose orientations contradict the others of their side.
    false_spins
        Spheres whose spins the impulse or the other sphere's spins contradict; they are not
        measured.
    heights
        By what a sphere that the top view does not show after contact has its height; sentences.
    flight_chi2
        Chi-squared per degree of freedom of positions, of both spheres before and after contact,
        shape (4,); not a number without freedom.
    spin_chi2
        The same of orientations.
    """

    impact: Impact
    used_before: tuple[int, ...]
    used_after: tuple[int, ...]
    between: tuple[int, ...]
    wild: tuple[tuple[str, int], ...]
    astray: tuple[tuple[str, int], ...]
    false_spins: tuple[str, ...]
    heights: tuple[str, ...]
    flight_chi2: Floats
    spin_chi2: Floats


def measure_two_sides(
    poses: ShotPoses,
    scene: Scene,
    *,
    three_and_three: bool = False,
    most_chi2: float = MOST_FLIGHT_CHI2,
) -> TwoSides:
    """Fit both sides of the contact and combine them.

    Without enough orientations the impact has no surface velocities.

    Parameters
    ----------
    three_and_three
        Take three frames on each side with the equations of the thesis.
    most_chi2
        Per degree of freedom, of a track that is a free flight.

    Raises
    ------
    ShotRefusedError
        No contact in the frames, too few frames on a side, paths that do not meet, or a track that
        is no free flight.
    """
    poses = poses.flat()
    left = poses.without(_tears(poses, scene))
    sides, contact, between = _sides(left, scene)
    wild = poses.placed & ~left.placed & ~np.isin(poses.frames, between)[:, None]
    if three_and_three:
        both = left.both_shown()
        before, after = (side.rows[both[side.rows]] for side in sides)
        sides = (
            Side("before", _three(before[::-1], left.times_s)[::-1], -1),
            Side("after", _three(after, left.times_s), 0),
        )
    depth_seen = bool(left.position[left.placed][:, 2].any())
    astray = np.zeros_like(left.turned)
    if not three_and_three:
        for side, i in product(sides, (0, 1)):
            astray[side.rows, i] = _astray(left, side, i, scene, depth_seen=depth_seen)
        left = left.without_turns(astray)
    for side, i in product(sides, (0, 1)):
        check_enough(left, side, i)
        if three_and_three:
            check_seen(left, side, i)
    motions: tuple[Motion, ...]
    heights: tuple[str, ...] = ()
    if three_and_three:
        motions = tuple(_thesis_motion(left, i, sides, contact, scene) for i in (0, 1))
    else:
        motions, heights = _fitted_motions(left, sides, contact, scene)
    for i, motion in enumerate(motions):
        for side, path in zip(sides, (motion.before, motion.after), strict=True):
            check_free_flight(left, side, i, path, most_chi2)
    impact = _impact(motions, scene, depth_seen=depth_seen)
    false = contradicted(impact, scene.bodies, depth_seen=depth_seen)
    if false:
        motions = _without_spins(motions, false)
        impact = _impact(motions, scene, depth_seen=depth_seen)
    check_possible(impact)
    check_parting(impact, left, *(side.rows for side in sides))
    check_opposite(impact, scene.bodies, depth_seen=depth_seen)
    return TwoSides(
        impact=impact,
        used_before=_numbers(left, sides[0].rows),
        used_after=_numbers(left, sides[1].rows),
        between=tuple(map(int, between)),
        wild=_named(poses, wild),
        astray=_named(poses, astray),
        false_spins=tuple("ab"[sphere] for sphere in false),
        heights=heights,
        flight_chi2=np.array([p.chi2_per_dof for m in motions for p in (m.before, m.after)]),
        spin_chi2=np.array(
            [
                np.nan if s is None else s.chi2_per_dof
                for m in motions
                for s in (m.spin_before, m.spin_after)
            ]
        ),
    )


def _impact(motions: Sequence[Motion], scene: Scene, *, depth_seen: bool) -> Impact:
    """Combine the motions of both spheres.

    Raises
    ------
    ShotRefusedError
        Their paths do not meet.
    """
    try:
        return measure_impact(
            *(motions[0], motions[1], scene.radii),
            scale_sigma=scene.slow.scale,
            offset_sigma=float(np.sqrt(2.0)) * scene.slow.common_m,
            held_sigma=float(np.sqrt(2.0)) * scene.slow.position_m,
            turn_sigma=scene.slow.common_rad,
            # A camera without a mirror leaves Z at zero in every frame.
            without_depth=None if depth_seen else scene.bodies,
        )
    except NoTouchError as miss:
        raise never_meet(miss, scene.radii) from miss


def _without_spins(motions: Sequence[Motion], spheres: Sequence[int]) -> tuple[Motion, ...]:
    return tuple(
        replace(motion, spin_before=None, spin_after=None) if i in spheres else motion
        for i, motion in enumerate(motions)
    )


def _named(poses: ShotPoses, chosen: NDArray[np.bool_]) -> tuple[tuple[str, int], ...]:
    """Return sphere and number of each chosen frame, from shape (F, 2)."""
    return tuple(("ab"[i], int(poses.frames[k])) for k, i in np.argwhere(chosen))


def _astray(
    poses: ShotPoses, side: Side, sphere: int, scene: Scene, *, depth_seen: bool
) -> NDArray[np.bool_]:
    """Return which orientations of a side contradict the others, shape (rows,)."""
    turned = poses.turned[side.rows, sphere]
    rows = side.rows[turned]
    sigma = np.hypot(poses.rotation_sigma[rows, sphere], scene.slow.rotation_rad)
    astray = np.zeros(len(side.rows), dtype=np.bool_)
    astray[turned] = ~agreeing_turns(
        poses.times_s[rows],
        poses.rotation[rows, sphere],
        sigma,
        least=LEAST_TOGETHER if depth_seen else LEAST_IN_ONE_VIEW,
    )
    return astray


def _numbers(poses: ShotPoses, rows: Frames) -> tuple[int, ...]:
    return tuple(map(int, poses.frames[rows]))


def _tears(poses: ShotPoses, scene: Scene) -> NDArray[np.bool_]:
    """Return which spheres in which frames are mis-tracked, shape (F, 2).

    A frame that is wrong for both lies between two sound ones; otherwise times or order of frames
    are wrong, which `check_free_flight` refuses.
    """
    rows = (np.flatnonzero(poses.placed[:, i]) for i in (0, 1))
    a, b = (poses.track(i, own) for i, own in enumerate(rows))
    off = cut_tears((a, b), poses.clock(), scene.gravity, sum(scene.radii))
    torn = np.stack([np.isin(poses.frames, list(own)) for own in off], axis=1)
    both = torn.all(axis=1)
    sound = poses.frames[poses.both_shown() & ~both]
    beside = np.isin(poses.frames - 1, sound) & np.isin(poses.frames + 1, sound)
    torn[both & ~beside] = False
    return torn


def _sides(poses: ShotPoses, scene: Scene) -> tuple[tuple[Side, Side], float, Frames]:
    """Return both sides, the time of first touch, and the frames between, by their numbers.

    Frames that may show the contact follow from its time; without them the time is found again.
    """
    shown = np.flatnonzero(poses.both_shown())
    before, after = _split(poses, shown, scene)
    for _ in range(2):
        contact, approach = _touch(poses, before, scene)
        check_between(contact, poses, before, after)
        since = poses.times_s - contact
        inside = inside_contact(since, np.array(approach), scene.bodies, scene.exposure_s)
        before = before[~inside[before] & (since[before] < 0)]
        after = after[~inside[after] & (since[after] > 0)]
        for side in (sides := (Side("before", before, -1), Side("after", after, 0))):
            check_enough(poses, side, None)
    return sides, contact, poses.frames[np.setdiff1d(shown, np.concatenate([before, after]))]


def _split(poses: ShotPoses, shown: Frames, scene: Scene) -> tuple[Frames, Frames]:
    """Return the rows before and after the kink of the tracks."""
    if shown.size == 0:
        raise ShotRefusedError("contact", "no frame shows both spheres")
    a, b = (poses.track(i, shown) for i in (0, 1))
    split = split_at_contact(a, b, poses.clock(), scene.gravity)
    later = poses.frames[shown] >= split
    return shown[~later], shown[later]


def _touch(poses: ShotPoses, before: Frames, scene: Scene) -> tuple[float, float]:
    """Return the time of first touch, s, and the speed of approach along the normal, m/s."""
    side, reference = Side("before", before, -1), float(poses.times_s[before[-1]])
    paths = []
    for i in (0, 1):
        check_seen(poses, side, i)
        paths.append(
            fit_flight(
                *_placed(poses, side, i),
                NO_MEMORY,
                gravity=scene.gravity,
                reference_s=reference,
                drag=NO_DRAG,
            )
        )
    try:
        contact = first_touch(paths[0], paths[1], scene.radii)
    except NoTouchError as miss:
        raise never_meet(miss, scene.radii) from miss
    (at_a, v_a), (at_b, v_b) = (path.at(contact) for path in paths)
    normal = (at_b - at_a) / np.linalg.norm(at_b - at_a)
    return contact, float(-(v_b - v_a) @ normal)


def _three(rows: Frames, times_s: Floats) -> Frames:
    """Choose three frames 2 ms apart, beginning with the first given."""
    chosen = list(rows[:1])
    for k in rows[1:]:
        gap = abs(times_s[k] - times_s[chosen[-1]])
        if gap >= THESIS_INTERVAL_S * (1 - 1e-3) and len(chosen) < LEAST_FRAMES:
            chosen.append(k)
    return np.array(chosen, dtype=np.intp)


def _drifts(
    poses: ShotPoses, sphere: int, sides: tuple[Side, Side], scene: Scene
) -> tuple[Drift, Drift]:
    """Return the slow errors of a sphere's centre, m, and orientation, rad.

    They last while it turns by what its markers are wide.
    """
    rates = [np.empty(0)]
    for side in sides:
        rows = side.rows[poses.turned[side.rows, sphere]]
        turns = rotation_vector(
            poses.rotation[rows[1:], sphere] @ poses.rotation[rows[:-1], sphere].swapaxes(1, 2)
        )
        rates.append(np.linalg.norm(turns, axis=1) / np.diff(poses.times_s[rows]))
    every = np.concatenate(rates)
    # Without two orientations there is no spin rate: the longest correlation time is taken.
    spin = float(np.median(every)) if every.size else 0.0
    lasting = correlation_time(scene.slow.memory_rad / 2, spin)
    return Drift(scene.slow.position_m, lasting), Drift(scene.slow.rotation_rad, lasting)


def _fitted_motions(
    poses: ShotPoses, sides: tuple[Side, Side], contact: float, scene: Scene
) -> tuple[tuple[Motion, ...], tuple[str, ...]]:
    """Fit all frames of both sides by least squares; say by what heights are known besides."""
    drifts = [_drifts(poses, i, sides, scene) for i in (0, 1)]

    def fit(sphere: int, placed: tuple[Floats, Floats, Floats]) -> FlightPath:
        return fit_flight(
            *placed,
            drifts[sphere][0],
            gravity=scene.gravity,
            reference_s=contact,
            drag=scene.drag(sphere),
        )

    first, second = ([_placed(poses, side, i) for i in (0, 1)] for side in sides)
    shown = sum(min(int(np.isfinite(own[2][:, 2]).sum()), LEAST_SHOWN) for own in second)
    for i in (0, 1):
        check_seen(poses, sides[0], i)
        check_seen(poses, sides[1], i, "XY" if shown >= LEAST_SHOWN else "XYZ")
    before = fit(0, first[0]), fit(1, first[1])
    masses = scene.bodies[0].mass, scene.bodies[1].mass
    try:
        touch, sigma = touch_with_error(*before, scene.radii, scene.slow.common_m, scene.slow.scale)
    except NoTouchError as miss:
        raise never_meet(miss, scene.radii) from miss
    at_touch = before[0].moved_to(touch), before[1].moved_to(touch)
    slow = scene.slow.position_m, sigma
    after, heights = paths_after(at_touch, (second[0], second[1]), masses, slow, fit)
    motions = []
    for i in (0, 1):
        turnings = [_turning(poses, side, i) for side in sides]
        spins = [
            fit_spin(*own, drifts[i][1]) if len(own[0]) >= LEAST_TURNS else None for own in turnings
        ]
        motions.append(Motion(before[i], after[i], spins[0], spins[1]))
    return tuple(motions), heights


def _thesis_motion(
    poses: ShotPoses, sphere: int, sides: tuple[Side, Side], contact: float, scene: Scene
) -> Motion:
    """Take three frames on each side, with an acceleration of their own instead of gravity."""
    centre, turn = _drifts(poses, sphere, sides, scene)
    paths: list[FlightPath] = []
    spins: list[Spin | None] = []
    for side in sides:
        path = three_frame_flight(*_placed(poses, side, sphere), centre, side.nearest)
        paths.append(path.moved_to(contact))
        turning = _turning(poses, side, sphere)
        determined = len(turning[0]) == LEAST_FRAMES
        spins.append(three_frame_spin(*turning, turn, side.nearest) if determined else None)
    return Motion(paths[0], paths[1], spins[0], spins[1])


def _placed(poses: ShotPoses, side: Side, sphere: int) -> tuple[Floats, Floats, Floats]:
    rows = side.rows
    return poses.times_s[rows], poses.position[rows, sphere], poses.position_sigma[rows, sphere]


def _turning(poses: ShotPoses, side: Side, sphere: int) -> tuple[Floats, Floats, Floats]:
    """Return times, orientations and their covariances of the frames of a side that have them."""
    rows = side.rows[poses.turned[side.rows, sphere]]
    spread = poses.rotation_sigma[rows, sphere, None, None] ** 2 * poses.turn_shape[rows, sphere]
    return poses.times_s[rows], poses.rotation[rows, sphere], spread
