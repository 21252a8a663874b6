"""Effects on friction and rotational restitution against hand-worked cases."""

import numpy as np
import pytest

from analysis.effects.contact import (
    friction_drift,
    friction_speed,
    rolling_restitution_speed,
    torsional_friction,
)
from analysis.effects.effect import ContactEffect
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

FAMILY = [
    (friction_speed.EFFECT, 0.2),
    (friction_drift.EFFECT, -0.4),
    (rolling_restitution_speed.EFFECT, 0.4),
    (torsional_friction.EFFECT, 1e-3),
]


@pytest.mark.parametrize(("effect", "value"), FAMILY, ids=[e.name for e, _ in FAMILY])
def test_momentum_and_separation_are_kept_and_energy_never_gained(
    effect: ContactEffect, value: float
) -> None:
    met = any_encounters()
    outcome = after(effect, value, met)
    assert np.allclose(momentum(outcome.after, met.bodies), momentum(met.before, met.bodies))
    assert np.allclose(separation(met, outcome), 0.74 * met.approach)
    assert (energy(outcome.after, met.bodies) <= energy(met.before, met.bodies)).all()


def friction(effect: ContactEffect, value: float, sliding: list[float]) -> np.ndarray:
    """Return mu from the sliding line: v_s - v_s' = mu (1 + e) 3.5 v_n, at v_n = 1 m/s."""
    met = head_on([1.0] * len(sliding), sliding)
    left = surface(after(effect, value, met).after, met.normal) @ X
    return (np.array(sliding) - left) / (1.74 * 3.5)


def test_friction_grows_with_the_logarithm_of_the_sliding_speed() -> None:
    """At 1 m/s mu is mu0; at e m/s it is mu0 (1 + a)."""
    found = friction(friction_speed.EFFECT, 0.1, [1.0, np.e, np.e**2])
    assert found == pytest.approx([0.08, 0.088, 0.096])


def test_friction_drifts_from_half_below_to_half_above() -> None:
    found = friction(friction_drift.EFFECT, 0.5, [2.0, 2.0, 2.0])
    assert found == pytest.approx([0.06, 0.08, 0.10])


def test_rotational_restitution_follows_the_logarithm_of_the_approach_speed() -> None:
    """Sticking: v_s' = -beta0 v_s, beta0 0.5 at 2 m/s and 0.5 (1 + a) at 2 e m/s."""
    met = head_on([2.0, 2.0 * np.e], 0.1)
    left = surface(after(rolling_restitution_speed.EFFECT, 0.2, met).after, met.normal) @ X
    assert left == pytest.approx([-0.05, -0.06])


def test_sliding_contacts_do_not_see_rotational_restitution() -> None:
    met = head_on(2.0, 3.0)
    changed = after(rolling_restitution_speed.EFFECT, 0.4, met).after
    assert np.array_equal(
        changed.velocity_b, after(rolling_restitution_speed.EFFECT, 0.0, met).after.velocity_b
    )


def test_torsion_brakes_the_relative_spin_by_the_published_amount() -> None:
    """(3 pi / 16) mu a (1 + e) v_n m* / I for 1 mm: 0.6 rad/s for each m/s (here 0.63)."""
    met = head_on(2.0, spin_about_normal=60.0)
    left = after(torsional_friction.EFFECT, 1e-3, met).after
    lost = 3 * np.pi / 16 * 0.08 * 1e-3 * 1.74 * 2.0 * NYLON.mass / 2 / NYLON.inertia
    assert lost / 2.0 == pytest.approx(0.63, abs=0.01)
    assert left.spin_b @ Y == pytest.approx([30.0 - lost])
    assert left.spin_a @ Y == pytest.approx([-30.0 + lost])


def test_torsion_keeps_spin_momentum_about_the_normal() -> None:
    met = any_encounters()
    bare, left = (after(torsional_friction.EFFECT, c, met).after for c in (0.0, 1e-3))
    assert np.allclose(left.spin_a + left.spin_b, bare.spin_a + bare.spin_b)
    assert np.abs(left.spin_a - bare.spin_a).max() > 0.1


def test_torsion_brings_relative_spin_to_rest_but_never_reverses_it() -> None:
    met = head_on(2.0, spin_about_normal=0.5)
    left = after(torsional_friction.EFFECT, 1e-3, met).after
    assert (left.spin_b - left.spin_a) @ Y == pytest.approx([0.0], abs=1e-12)


def test_radius_of_contact_grows_with_the_two_fifths_power_of_approach() -> None:
    met = head_on([2.0, 4.0], spin_about_normal=60.0)
    lost = 30.0 - after(torsional_friction.EFFECT, 1e-3, met).after.spin_b @ Y
    assert lost[1] / lost[0] == pytest.approx(2.0**1.4)
