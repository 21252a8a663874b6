"""A camera without a mirror: numbers of impacts with depth, measured as if there were none."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.collision.coefficients import Impact, Motion, measure_impact
from analysis.collision.operator import Body
from analysis.motion.spin import Spin
from analysis.motion.velocity import FlightPath

R = 0.0127
E, MU = 0.74, 0.08
BALL = Body.sphere(2.0 * R, 1140.0, 0.4)
NOTHING = np.zeros((6, 6))
ASIDE = np.array([0.0, 1.0, 0.0])
Floats = NDArray[np.float64]


def flat(place: Floats, velocity: Floats, slowed: float = 0.0) -> FlightPath:
    """Return a path as a camera without a mirror gives it: exact, but for the depth.

    One standard error of drag slows it by so much of its velocity.
    """
    shown = np.array([1.0, 1.0, 0.0])
    shift = np.concatenate([np.zeros(3), slowed * velocity * shown])
    return FlightPath(0.0, place * shown, velocity * shown, np.zeros(3), NOTHING, 1.0, shift)


def seen(
    rng: np.random.Generator,
    depth: float,
    *,
    markers: bool = True,
    spin_sigma: float = 0.0,
    moment: float = 0.0,
    scale_sigma: float = 0.0,
    slowed: float = 0.0,
    aside: float = 0.0,
) -> tuple[Impact, float, float]:
    """Return what is measured of a sliding impact of two like spheres, its true beta and tilt.

    `depth` scales how far the spheres lie off in depth, and drift in it; without `markers` no spin
    is seen, and with them as well as `spin_sigma` in rad/s has it. `moment` is what a moment about
    the normal at the contact changes a spin by, rad/s. `scale_sigma` and `slowed` are what is
    unsure for all shots alike, and `aside` lets paths after the contact be seen apart, in radii.
    """
    off = depth * 0.015 * 2.0 * R * rng.standard_normal(2)
    drift = depth * 0.005 * 2.0 * rng.standard_normal(2)
    normal = np.array([0.5, np.sqrt(0.75), 0.0])
    normal[2] = (off[1] - off[0]) / (2.0 * R)
    normal /= np.linalg.norm(normal)
    velocity = np.array([[0.1, 2.0, drift[0]], [0.1, -2.0, drift[1]]])
    spin = rng.normal(0.0, 20.0, (2, 3)) * np.array([depth, depth, 1.0])
    between = velocity[1] - velocity[0]
    v_n = float(between @ normal)
    slip = between - v_n * normal + np.cross(normal, R * (spin[0] + spin[1]))
    v_s = float(np.linalg.norm(slip))
    # Impulse on b over its mass: half the change of v_n along the normal, Coulomb's share across.
    along = -0.5 * (1.0 + E) * v_n
    push = along * normal - MU * along * slip / v_s
    after = velocity + np.array([-push, push])
    # Both spheres are turned alike, a by -J at R n and b by J at -R n: I = 2/5 m R^2.
    spin_after = spin - 2.5 / R * np.cross(normal, push)
    between_after = after[1] - after[0]
    slip_after = between_after - float(between_after @ normal) * normal
    slip_after += np.cross(normal, R * (spin_after[0] + spin_after[1]))
    spin_after += moment * normal * np.array([[-1.0], [1.0]])
    noise = spin_sigma * rng.standard_normal((2, 2, 3))
    unsure = spin_sigma**2 * np.eye(3)
    places = np.array([-normal * R, normal * R])
    motions = [
        Motion(
            flat(places[i], velocity[i], slowed),
            flat(places[i] + (2 * i - 1) * 0.5 * aside * R * ASIDE, after[i], -slowed),
            Spin(spin[i] + noise[0, i], unsure, 1.0) if markers else None,
            Spin(spin_after[i] + noise[1, i], unsure, 1.0) if markers else None,
        )
        for i in (0, 1)
    ]
    impact = measure_impact(
        *motions, radii=(R, R), scale_sigma=scale_sigma, without_depth=(BALL, BALL)
    )
    return impact, -float(slip_after @ slip) / v_s**2, float(normal[2])


def test_the_impact_of_this_test_obeys_its_own_law() -> None:
    impact, beta, _ = seen(np.random.default_rng(1), 0.0)
    assert impact.e.value == pytest.approx(E, abs=1e-9)
    assert impact.beta is not None
    assert impact.beta.value == pytest.approx(beta, abs=1e-9)
    # Sliding: beta = -1 + (7/2) mu (1 + e) |v_n| / v_s (thesis, section 7.1).
    assert impact.v_s is not None
    sliding = -1.0 + 3.5 * MU * (1.0 + E) * -impact.v_n.value / impact.v_s.value
    assert beta == pytest.approx(sliding, abs=1e-9)


def test_coefficients_lie_within_their_errors_whatever_the_unseen_depth() -> None:
    rng = np.random.default_rng(5)
    off_e, off_beta = [], []
    for _ in range(150):
        impact, beta, _ = seen(rng, 1.0, spin_sigma=0.1)
        off_e.append((impact.e.value - E) / impact.e.sigma)
        assert impact.beta is not None
        off_beta.append((impact.beta.value - beta) / impact.beta.sigma)
    # Draws of one size enter by their square: rms 1 within a third, hardly any beyond 4. The
    # mean of 150 is 0 within 0.08: friction that pushes spheres out of the picture has no one sign.
    for off in (np.array(off_e), np.array(off_beta)):
        assert 0.6 < np.sqrt((off**2).mean()) < 1.4
        assert (np.abs(off) > 4.0).sum() <= 3
    assert abs(np.mean(off_beta)) < 0.3


@pytest.mark.parametrize("moment", [0.0, 5.0])
def test_spins_show_how_far_the_normal_lies_off_the_picture(moment: float) -> None:
    """Whatever moments the contact has: they are opposite, and cancel in the sum of both spins."""
    rng = np.random.default_rng(7)
    tilts, off = [], []
    for _ in range(100):
        impact, _, tilt = seen(rng, 1.0, spin_sigma=0.1, moment=moment)
        tilts.append(tilt)
        off.append((impact.normal[2] - tilt) / impact.normal_sigma[2])
        # Friction changes spins by 60 rad/s here: 0.1 rad/s of four of them turn what they show.
        assert impact.normal_sigma[2] < 0.2 * 0.021
    assert np.std(tilts) > 0.015
    assert 0.75 < np.sqrt(np.mean(np.square(off))) < 1.25


def test_spins_that_are_hardly_known_leave_the_normal_as_open_as_launches_do() -> None:
    rng = np.random.default_rng(8)
    off = []
    for _ in range(100):
        impact, _, tilt = seen(rng, 1.0, spin_sigma=20.0)
        off.append((impact.normal[2] - tilt) / impact.normal_sigma[2])
        assert 0.01 < impact.normal_sigma[2] < 0.0213
    assert 0.75 < np.sqrt(np.mean(np.square(off))) < 1.25


def test_a_tilt_that_no_launch_gives_is_not_taken_from_spins() -> None:
    """A spin changes twice as much about the normal in the picture as across it."""
    place, speed = np.array([0.0, R, 0.0]), np.array([0.0, 2.0, 0.0])
    exact = np.zeros((3, 3))
    wrong = Spin(np.array([0.0, 40.0, 20.0]), exact, 1.0)
    still = Spin(np.zeros(3), exact, 1.0)
    a = Motion(flat(-place, speed), flat(-place, -0.7 * speed), still, wrong)
    b = Motion(flat(place, -speed), flat(place, 0.7 * speed), still, still)
    impact = measure_impact(a, b, (R, R), 0.0, without_depth=(BALL, BALL))
    assert impact.normal[2] == 0.0


@pytest.mark.parametrize("scale_sigma", [3e-4, 3e-3])
def test_what_all_shots_share_is_a_part_of_the_whole_error(scale_sigma: float) -> None:
    """What spins show of depth is shown by shared errors too, and they take part of it."""
    rng = np.random.default_rng(9)
    for _ in range(60):
        impact, _, _ = seen(rng, 1.0, spin_sigma=0.1, scale_sigma=scale_sigma, slowed=1e-3)
        held = impact.shared[:2]
        own = np.linalg.eigvalsh(impact.covariance - held.T @ held)
        assert own.min() > -1e-9 * own.max()
        for told in (impact.e, impact.beta, impact.v_n, impact.v_s, impact.v_n_after):
            assert told is not None
            assert told.common is not None
            assert told.common <= told.sigma * (1.0 + 1e-9)


def test_spins_show_depth_where_paths_after_the_contact_tell_no_duration() -> None:
    tilts, off = [], []
    rng = np.random.default_rng(10)
    for _ in range(60):
        impact, _, tilt = seen(rng, 1.0, spin_sigma=0.1, aside=1.5)
        assert impact.duration is None
        tilts.append(tilt)
        off.append((impact.normal[2] - tilt) / impact.normal_sigma[2])
        assert impact.normal_sigma[2] < 0.3 * 0.021
    assert np.std(tilts) > 0.015
    assert 0.6 < np.sqrt(np.mean(np.square(off))) < 1.25


def test_a_shot_that_just_grazes_is_measured_whatever_depth_its_spins_show() -> None:
    """They pass at 0.9995 of the reach, which leaves room for a tilt of 0.032 of the normal."""
    normal = np.array([0.9995, np.sqrt(1.0 - 0.9995**2), 0.0])
    place, speed = R * normal, np.array([0.0, 2.0, 0.0])
    unsure = 0.1**2 * np.eye(3)
    still, tilt = Spin(np.zeros(3), unsure, 1.0), {"room": 0.02, "none": 0.05}
    found = {}
    for name, size in tilt.items():
        turned = Spin(np.array([30.0 * size, 0.0, -30.0]), unsure, 1.0)
        a = Motion(flat(-place, speed), flat(-place, 0.99 * speed), still, turned)
        b = Motion(flat(place, -speed), flat(place, -0.99 * speed), still, turned)
        found[name] = measure_impact(a, b, (R, R), 0.0, without_depth=(BALL, BALL))
    assert found["room"].normal[2] == pytest.approx(tilt["room"], rel=0.1)
    # Where there is none, the normal stays in the picture, as unsure as launches leave it.
    np.testing.assert_allclose(found["none"].normal, normal, atol=1e-12)
    assert found["none"].normal_sigma[2] > 0.02


def test_without_spins_restitution_stays_within_its_error() -> None:
    rng = np.random.default_rng(6)
    off = []
    for _ in range(150):
        impact, _, _ = seen(rng, 1.0, markers=False)
        assert impact.v_s is None
        off.append((impact.e.value - E) / impact.e.sigma)
    # Friction in depth is assumed for any spin; these spheres spin less: wide by up to a factor 3.
    assert 0.33 < np.sqrt(np.mean(np.square(off))) < 1.25
    assert np.abs(off).max() < 4.0


def test_depth_that_is_seen_adds_no_error() -> None:
    place, speed = np.array([0.0, R, 0.0]), np.array([0.0, 2.0, 0.0])
    still = Spin(np.zeros(3), np.zeros((3, 3)), 1.0)
    a = Motion(flat(-place, speed), flat(-place, -0.7 * speed), still, still)
    b = Motion(flat(place, -speed), flat(place, 0.7 * speed), still, still)
    assert measure_impact(a, b, (R, R), 0.0).e.sigma == 0.0
    assert measure_impact(a, b, (R, R), 0.0, without_depth=(BALL, BALL)).e.sigma > 0.0
