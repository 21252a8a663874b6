"""Tangential compliance against Maw, Barber and Fawcett's curve and its limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.collision.operator import walton
from analysis.effects.contact import inertia_factor, restitution_plastic, tangential_compliance
from analysis.effects.contact.spring_slider import (
    dashpot,
    impact,
    integrated,
    kept_tables,
    line_of_springs,
    rebound,
    single_spring,
    table_name,
)
from analysis.effects.contact.spring_slider_tables import required_tables
from analysis.effects.effect import ContactEffect
from tests.unit.analysis.effects.encounters import (
    X,
    after,
    any_encounters,
    energy,
    head_on,
    momentum,
    separation,
    surface,
)

EFFECT = tangential_compliance.EFFECT
KAPPA = 6 / 7
CHI = {line_of_springs: 1.5, single_spring: 0.3}
INCIDENCE = np.array([0.25, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5, 6, 7])
SOLID_QUARTER = np.array(
    [
        0.0562,
        0.0814,
        0.0154,
        -0.3296,
        -0.7442,
        -1.0882,
        -1.3345,
        -1.4720,
        -1.4864,
        -1.3501,
        -1,
        0,
        1,
    ]
)
"""Rebound of an elastic solid sphere with Poisson's ratio 1/4, at each incidence."""


def test_the_curve_of_an_elastic_solid_sphere_is_reproduced() -> None:
    assert rebound(INCIDENCE, 1.5, np.ones(13)) == pytest.approx(SOLID_QUARTER, abs=1e-3)


def test_the_curve_stands_in_the_fields_units_in_the_outcome() -> None:
    """v_s' = (mu v_n / kappa) f(kappa v_s / (mu v_n))."""
    unit = 0.08 * 2.0 / KAPPA
    met = head_on([2.0] * 13, list(INCIDENCE * unit), law=(1.0, 0.08, 0.5))
    left = surface(after(EFFECT, 1.0, met).after, met.normal) @ X
    assert left / unit == pytest.approx(SOLID_QUARTER, abs=1e-3)


@pytest.mark.parametrize(("poisson", "largest"), [(0.25, 0.446), (0.30, 0.468), (0.40, 0.522)])
def test_the_largest_rotational_restitution_is_the_published_one(
    poisson: float, largest: float
) -> None:
    psi = np.linspace(1.0, 5.0, 400)
    kappa = 2 * (1 - poisson) / (2 - poisson)
    found, _ = impact(psi, kappa, 3.5, 0.0)
    assert (-found / psi).max() == pytest.approx(largest, abs=1e-3)


@pytest.mark.parametrize(("e", "largest"), [(0.71, 0.46), (0.61, 0.54)])
def test_damping_raises_the_largest_rotational_restitution_as_published(
    e: float, largest: float
) -> None:
    psi = np.linspace(0.5, 8.0, 400)
    assert (-rebound(psi, 1.5, np.full(400, e)) / psi).max() == pytest.approx(largest, abs=0.016)


def test_elastic_contacts_slide_throughout_beyond_seven_kappa_less_one() -> None:
    psi = np.array([5.0, 5.5, 7.0, 40.0, 1000.0])
    assert rebound(psi, 1.5, np.ones(5)) == pytest.approx(psi - 6.0, abs=1e-6)


def test_integration_of_the_springs_has_converged_in_time_and_returns_e() -> None:
    _, e = impact(np.zeros(1), KAPPA, 3.5, 0.0)
    assert e == pytest.approx(1.0, abs=1e-6)
    assert impact(np.zeros(1), KAPPA, 3.5, dashpot(0.74))[1] == pytest.approx(0.74, abs=1e-6)


@pytest.mark.parametrize(("chi", "e"), [(1.5, 0.74), (1.525, 0.9), (1.225, 0.625)])
def test_between_tables_the_curve_is_that_of_the_springs_themselves(chi: float, e: float) -> None:
    psi = np.linspace(0.1, 10.0, 67)
    true, _ = impact(psi, 2 * chi / 3.5, 3.5, dashpot(e))
    assert rebound(psi, chi, np.full(67, e)) == pytest.approx(true, abs=0.01)


def swinging(psi: float, kappa: float, steps: int = 40000) -> float:
    """Follow Cundall's and Strack's spring on an elastic Hertz contact in plain small steps."""
    depth, speed, slip, stretch = 0.0, 1.0, psi / kappa, 0.0
    step = 4.0 / steps
    while depth >= 0.0:
        push, stiffness = 4 / 3 * depth**1.5, 2 * kappa * depth**0.5
        stretch += slip * step
        if abs(stiffness * stretch) > push:
            stretch = np.copysign(push / stiffness, stretch) if stiffness else 0.0
        speed -= push * step
        slip -= 3.5 * stiffness * stretch * step
        depth += speed * step
    return kappa * slip


@pytest.mark.parametrize("kappa", [0.15, 6 / 7])
def test_the_single_spring_swings_back_as_followed_in_small_steps(kappa: float) -> None:
    psi = np.array([0.1, 0.3, 0.5, 1.0, 2.0, 4.0])
    ours, e = impact(psi, kappa, 3.5, 0.0, single_spring)
    assert e == pytest.approx(1.0, abs=1e-5)
    assert ours == pytest.approx([swinging(p, kappa) for p in psi], abs=2e-3)


def test_the_soft_single_spring_reverses_the_surface_velocity_as_the_thesis_found() -> None:
    psi = np.linspace(0.01, 0.6, 60)
    found = rebound(psi, 0.15 * 3.5 / 2, np.full(60, 0.74), single_spring)
    assert (-found / psi).max() == pytest.approx(0.69, abs=0.1)


def test_only_kappa_times_the_lever_matters() -> None:
    psi = np.linspace(0.1, 8.0, 40)
    assert impact(psi, 0.7, 3.5, 0.2)[0] == pytest.approx(impact(psi, 0.98, 2.5, 0.2)[0], abs=1e-9)


def test_far_beyond_the_corner_the_law_is_coulombs() -> None:
    met = head_on(1.0, 4.0)
    soft, hard = (after(EFFECT, a, met).after for a in (1.0, 0.0))
    assert soft.velocity_b == pytest.approx(hard.velocity_b, abs=2e-4)


def test_small_angles_leave_with_the_surface_velocity_they_came_with() -> None:
    met = head_on(2.0, 0.04, law=(1.0, 0.08, 0.5))
    left = surface(after(EFFECT, 1.0, met).after, met.normal) @ X
    assert 0 < left[0] < 0.04


def test_half_of_it_lies_half_way() -> None:
    met = any_encounters()
    none, half, full = (after(EFFECT, a, met).after.spin_b for a in (0.0, 0.5, 1.0))
    assert np.allclose(half, (none + full) / 2)


@pytest.mark.parametrize(
    ("effect", "e"),
    [(effect, e) for effect in (EFFECT, *EFFECT.variants) for e in (0.5, 0.74)] + [(EFFECT, 1.0)],
    ids=lambda part: getattr(part, "title", part),
)
def test_momentum_and_separation_are_kept_and_energy_never_gained(
    effect: ContactEffect, e: float
) -> None:
    met = any_encounters(law=(e, 0.3, 0.5))
    outcome = after(effect, 1.0, met)
    assert np.allclose(momentum(outcome.after, met.bodies), momentum(met.before, met.bodies))
    assert np.allclose(separation(met, outcome), e * met.approach)
    assert (energy(outcome.after, met.bodies) <= energy(met.before, met.bodies) * (1 + 1e-9)).all()


def test_effects_of_restitution_and_inertia_reach_the_compliant_law_in_either_order() -> None:
    met = any_encounters()
    one = np.ones(1)
    for other, value in ((restitution_plastic.EFFECT, 0.2), (inertia_factor.EFFECT, 0.1)):
        inside = EFFECT.wrap(other.wrap(walton, value * one), one)(met)
        outside = other.wrap(EFFECT.wrap(walton, one), value * one)(met)
        assert np.allclose(inside.after.spin_a, outside.after.spin_a)
        assert not np.allclose(inside.after.spin_a, after(EFFECT, 1.0, met).after.spin_a)


def test_contacts_without_friction_or_approach_leave_finite_numbers() -> None:
    met = any_encounters()
    smooth = after(EFFECT, 1.0, replace(met, mu=np.zeros(300))).after
    assert np.allclose(smooth.spin_a, met.before.spin_a, atol=1e-3)
    grazing = after(EFFECT, 1.0, replace(met, normal=-met.normal)).after
    assert np.isfinite(grazing.spin_a).all()


def test_kept_tables_are_those_that_integration_gives() -> None:
    for pressing in (line_of_springs, single_spring):
        made = integrated(pressing, CHI[pressing], 0.75)
        assert kept_tables()[table_name(pressing, CHI[pressing], 0.75)] == pytest.approx(
            made, abs=1e-5
        )


def test_every_table_that_a_solid_sphere_needs_is_kept() -> None:
    assert set(kept_tables()) == {table_name(*each) for each in required_tables()}
