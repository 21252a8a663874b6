"""Right and wrong spins of both spheres, beside the impulse that turns them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.collision.coefficients import Impact, Motion, measure_impact
from analysis.collision.operator import Body
from analysis.collision.spin_balance import contradicted, spins_apart, spins_off, sum_off
from analysis.motion.spin import Spin
from analysis.motion.velocity import FlightPath

R = 0.0127
BALL = Body.sphere(2.0 * R, 1140.0, 0.4)
NORMAL = np.array([0.4, np.sqrt(0.84), 0.0])
SURE, LESS_SURE = 0.1, 0.25
"""Standard errors of the spins of a and b, rad/s."""
Floats = NDArray[np.float64]


def seen(
    torsion: float,
    wrong: Floats | None = None,
    sigmas: tuple[float, float] = (SURE, LESS_SURE),
    *,
    inertia_factor: float = 0.4,
) -> Impact:
    """Return an impact in one view whose spins obey their impulse.

    `torsion` is what a moment about the normal changes either spin by, rad/s, and `wrong` what is
    seen of spins after contact and is not true, of b or of both, shape (3,) or (2, 3).
    """
    push = np.array([-0.25, 3.1, 0.05])
    velocity = np.array([[0.1, 2.0, 0.0], [0.1, -2.0, 0.0]])
    after = velocity + np.array([-push, push])
    spin = np.array([[3.0, -2.0, 15.0], [1.0, 4.0, -8.0]])
    # Both spheres are turned alike, a by -J at R n and b by J at -R n.
    spin_after = spin - np.cross(NORMAL, push) / (inertia_factor * R)
    spin_after += torsion * NORMAL * np.array([[-1.0], [1.0]])
    if wrong is not None:
        spin_after += np.array([[0.0], [1.0]]) * wrong if wrong.ndim == 1 else wrong
    motions = []
    for i, sigma in enumerate(sigmas):
        place = (2 * i - 1) * R * NORMAL
        unsure = np.diag([1e-6] * 2 + [0.0] + [1e-3] * 2 + [0.0]) ** 2
        paths = [
            FlightPath(0.0, place, v * [1.0, 1.0, 0.0], np.zeros(3), unsure, 1.0, np.zeros(6))
            for v in (velocity[i], after[i])
        ]
        spins = [Spin(w, sigma**2 * np.eye(3), 1.0) for w in (spin[i], spin_after[i])]
        motions.append(Motion(*paths, *spins))
    return measure_impact(motions[0], motions[1], (R, R), 0.0, without_depth=(BALL, BALL))


@pytest.mark.parametrize("torsion", [0.0, 2.5, -10.0])
def test_a_moment_about_the_normal_makes_no_spin_a_wrong_one(torsion: float) -> None:
    assert contradicted(seen(torsion), (BALL, BALL), depth_seen=False) == ()


def test_spins_that_differ_about_the_normal_alone_do_not_differ() -> None:
    still, turned = seen(0.0), seen(5.0)
    assert np.linalg.norm(turned.after.spin_b - still.after.spin_b) == pytest.approx(5.0)
    assert spins_apart(turned, (BALL, BALL)) < spins_apart(still, (BALL, BALL)) + 0.1


@pytest.mark.parametrize("torsion", [0.0, 5.0])
def test_a_sphere_that_is_seen_in_a_wrong_turn_across_the_normal_is_found(torsion: float) -> None:
    """Out of the picture's plane no velocity tells: the other sphere's spin does."""
    across = 20.0 * np.array([-NORMAL[1], NORMAL[0], 0.0])
    assert contradicted(seen(torsion, across), (BALL, BALL), depth_seen=False) == (1,)


def test_a_spin_that_velocities_contradict_is_found() -> None:
    about_z = np.array([0.0, 0.0, 60.0])
    assert contradicted(seen(0.0, about_z), (BALL, BALL), depth_seen=False) == (1,)


def test_of_two_spins_as_sure_as_each_other_the_one_that_velocities_contradict_is_wrong() -> None:
    wrong = np.array([0.0, 0.0, 20.0])
    alike = seen(0.0, wrong, (LESS_SURE, LESS_SURE))
    assert contradicted(alike, (BALL, BALL), depth_seen=False) == (1,)


def test_where_velocities_show_nothing_of_a_wrong_turn_no_sphere_is_named_by_chance() -> None:
    across = 20.0 * np.array([-NORMAL[1], NORMAL[0], 0.0])
    noise = np.random.default_rng(3)
    named = set()
    for _ in range(40):
        drawn = across + LESS_SURE * noise.standard_normal(3)
        alike = seen(0.0, drawn, (LESS_SURE, LESS_SURE))
        assert spins_apart(alike, (BALL, BALL)) > 0.8
        named.add(contradicted(alike, (BALL, BALL), depth_seen=False))
    assert named == {()}


def test_two_spins_that_are_wrong_alike_contradict_what_the_impulse_turns_both_by() -> None:
    """Neither changes at all: no moment between two spheres stops both."""
    right = seen(0.0)
    changes = np.stack(
        [right.after.spin_a - right.before.spin_a, right.after.spin_b - right.before.spin_b]
    )
    still = seen(0.0, -changes, (LESS_SURE, LESS_SURE))
    assert spins_apart(still, (BALL, BALL)) < 0.1
    assert contradicted(still, (BALL, BALL), depth_seen=False) == (0, 1)


@pytest.mark.parametrize("depth_seen", [False, True])
def test_a_moment_that_turns_both_against_each_other_makes_no_spins_wrong(
    depth_seen: bool,
) -> None:
    """As the resistance to rolling does, about Z: what one gains the other one loses."""
    rolling = seen(0.0, np.array([[0.0, 0.0, -60.0], [0.0, 0.0, 60.0]]))
    assert (spins_off(rolling, (BALL, BALL), depth_seen=depth_seen) > 3.0).all()
    assert sum_off(rolling, (BALL, BALL), depth_seen=depth_seen) < 1.0


@pytest.mark.parametrize("inertia_factor", [0.25, 0.4, 0.66])
@pytest.mark.parametrize("depth_seen", [False, True])
def test_balls_that_are_heavier_inside_or_outside_than_stated_have_no_wrong_spins(
    inertia_factor: float, depth_seen: bool
) -> None:
    other = seen(0.0, inertia_factor=inertia_factor)
    assert contradicted(other, (BALL, BALL), depth_seen=depth_seen) == ()


def test_a_plate_has_no_spin_to_compare_with() -> None:
    wrong = seen(0.0, np.array([20.0, 0.0, 60.0]))
    plate = replace(
        wrong,
        state_sigma=wrong.state_sigma * np.array([1.0, 0.0, 1.0, 0.0])[:, None],
    )
    bodies = (BALL, Body.plate())
    assert np.isnan(spins_apart(plate, bodies))
    assert contradicted(plate, bodies, depth_seen=False) == ()
