"""Effects of the bodies against conservation laws and hand-worked cases."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.collision.operator import Body, walton
from analysis.effects.contact import inertia_factor, mass_mismatch, radius_mismatch
from tests.unit.analysis.effects.encounters import (
    NYLON,
    X,
    Y,
    after,
    any_encounters,
    energy,
    head_on,
    momentum,
    separation,
    surface,
)


def test_mass_mismatch_moves_the_mean_velocity_by_half_of_it_times_the_change() -> None:
    """Change of (v_a + v_b) / 2 = (d / 2) times the change of v_b - v_a."""
    met = any_encounters()
    left, d = after(mass_mismatch.EFFECT, 0.01, met).after, 0.01
    mean = (left.velocity_a + left.velocity_b - met.before.velocity_a - met.before.velocity_b) / 2
    apart = left.velocity_b - left.velocity_a - met.before.velocity_b + met.before.velocity_a
    assert np.allclose(mean, d / 2 * apart, atol=1e-12)


def test_mass_mismatch_keeps_the_momentum_of_the_true_masses_and_loses_energy() -> None:
    met = any_encounters()
    left = after(mass_mismatch.EFFECT, 0.02, met).after
    true = tuple(Body(NYLON.mass * f, NYLON.radius, NYLON.inertia * f) for f in (1.02, 0.98))
    assert np.allclose(momentum(left, true), momentum(met.before, true))
    assert (energy(left, true) <= energy(met.before, true)).all()


def test_the_heavier_sphere_changes_its_velocity_less() -> None:
    left = after(mass_mismatch.EFFECT, 0.02, head_on(2.0)).after
    assert left.velocity_a @ Y < 0
    assert -left.velocity_a @ Y < left.velocity_b @ Y


def test_mass_mismatch_keeps_restitution() -> None:
    met = any_encounters()
    assert np.allclose(separation(met, after(mass_mismatch.EFFECT, 0.02, met)), 0.74 * met.approach)


def test_inertia_factor_shares_the_change_between_spin_and_translation() -> None:
    """dv_t = dv_s / (1 + 1/K): K = 2/5 gives 2/7 of it, K = 2/3 of a shell gives 2/5."""
    met = head_on(2.0, 0.1)
    for k, share in ((0.0, 2 / 7), (2 / 3, 2 / 5)):
        left = after(inertia_factor.EFFECT, k, met).after
        change_s = surface(left, met.normal) @ X - 0.1
        change_t = (left.velocity_b - left.velocity_a) @ X - 0.1
        assert change_s == pytest.approx([-0.15])
        assert change_t / change_s == pytest.approx([share])


def test_the_impulse_of_sliding_friction_does_not_depend_on_inertia() -> None:
    met = head_on(2.0, 3.0)
    solid, shell = (after(inertia_factor.EFFECT, k, met).after for k in (0.0, 2 / 3))
    assert np.allclose(shell.velocity_b, solid.velocity_b)
    assert np.allclose(shell.spin_b * 5 / 3, solid.spin_b)


def collided_from_true_touch(
    radii: tuple[float, float], offset: float, time: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return both centres at a time after homogeneous spheres of these radii met, frictionless.

    Sphere b comes along -Y with 2 m/s past a at rest, its line `offset` off along X; time 0 is
    when the centres are a nylon diameter apart. Worked out from where the true spheres touch.
    """
    reach = sum(radii)
    start = np.array([offset, np.sqrt((2 * NYLON.radius) ** 2 - offset**2), 0.0])
    touch = (start[1] - np.sqrt(reach**2 - offset**2)) / 2.0
    normal = (start - 2.0 * touch * Y) / reach
    mass_a, mass_b = radii[0] ** 3, radii[1] ** 3
    impulse = 1.74 * 2.0 * normal[1] * normal / (1 / mass_a + 1 / mass_b)
    place_a = -impulse / mass_a * (time - touch)
    place_b = start - 2.0 * touch * Y + (impulse / mass_b - 2.0 * Y) * (time - touch)
    return place_a, place_b


@pytest.mark.parametrize("shares", [(0.01, 0.0), (0.0, -0.01), (0.004, 0.002), (-0.003, 0.003)])
@pytest.mark.parametrize("offset", [0.0, 0.01, 0.02])
def test_spheres_of_other_radii_kink_where_they_truly_touch(
    shares: tuple[float, float], offset: float
) -> None:
    met = head_on(2.0, law=(0.74, 0.0, 0.5))
    normal = np.array([[offset, np.sqrt((2 * NYLON.radius) ** 2 - offset**2), 0.0]])
    still = np.zeros((1, 3))
    before = replace(met.before, velocity_a=still, velocity_b=-2.0 * Y[None])
    met = replace(met, normal=normal / (2 * NYLON.radius), before=before)
    outcome = after(radius_mismatch.EFFECT, list(shares), met)
    late = 5e-3
    since = late - outcome.duration[:, None]
    place_a = outcome.shift_a + outcome.after.velocity_a * since
    place_b = normal + outcome.shift_b + outcome.after.velocity_b * since
    radii = (NYLON.radius * (1 + shares[0]), NYLON.radius * (1 + shares[1]))
    true_a, true_b = collided_from_true_touch(radii, offset, late)
    assert place_a[0] == pytest.approx(true_a, abs=1e-12)
    assert place_b[0] == pytest.approx(true_b, abs=1e-12)


def test_larger_spheres_touch_earlier_and_turn_less_before() -> None:
    met = replace(
        head_on(2.0), before=replace(head_on(2.0).before, spin_a=np.array([[0, 0, 50.0]]))
    )
    outcome = after(radius_mismatch.EFFECT, [0.005, 0.005], met)
    earlier = 0.005 * 2 * NYLON.radius / 2.0
    assert outcome.duration == pytest.approx([-earlier])
    assert outcome.turn_a[0, 2] == pytest.approx(-50.0 * earlier)


def test_lever_arms_are_the_true_radii() -> None:
    """A sphere a that is 1 % larger slides 1 % faster at its surface for the same spin."""
    still = head_on(2.0)
    met = replace(still, before=replace(still.before, spin_a=np.array([[0.0, 0.0, 5.0]])))
    small, large = (
        replace(met, bodies=(Body(NYLON.mass, NYLON.radius * f, NYLON.inertia), NYLON))
        for f in (1.0, 1.01)
    )
    assert large.sliding_speed / small.sliding_speed == pytest.approx([1.01])
    outcome = after(radius_mismatch.EFFECT, [0.01, -0.01], met)
    bodies = (
        Body(NYLON.mass * 1.01**3, NYLON.radius * 1.01, NYLON.inertia * 1.01**5),
        Body(NYLON.mass * 0.99**3, NYLON.radius * 0.99, NYLON.inertia * 0.99**5),
    )
    expected = walton(replace(met, bodies=bodies)).after
    assert outcome.after.spin_a == pytest.approx(expected.spin_a)
    assert outcome.after.velocity_b == pytest.approx(expected.velocity_b)
