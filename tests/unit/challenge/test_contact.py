from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from simulators.challenge.bodies import Bodies
from simulators.challenge.bristles import STIFFNESS_RATIO, impulse_ratio
from simulators.challenge.coefficients import Coefficients
from simulators.challenge.impact import grip, strike, twist
from simulators.challenge.launch import Touch
from simulators.challenge.nature import Nature
from simulators.challenge.pressing import Passage, hertz_duration, press
from simulators.challenge.viscoelastic import restitution_of, softening
from simulators.world.description import Sphere

Floats = NDArray[np.float64]

NYLON = Sphere()
PLAIN = Nature()
SIDES = np.array([-1.0, 1.0])[:, None]


def touches(shots: int = 200, seed: int = 1) -> Touch:
    """Return spheres that meet in every direction, with every spin."""
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=(shots, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    velocity = rng.normal(0.0, 1.0, (shots, 2, 3))
    velocity -= SIDES * (0.5 + rng.uniform(0.0, 2.0, (shots, 1, 1)) + 3.0) * normal[:, None] / 2
    touch = Touch(rng.normal(size=(shots, 3)), normal, velocity, rng.normal(0, 90, (shots, 2, 3)))
    approaching = touch.approach > 0.3
    return Touch(*(array[approaching] for array in (touch.point, normal, velocity, touch.spin)))


def held(touch: Touch, e: float = 0.74, mu: float = 0.08, beta0: float = 0.5) -> Coefficients:
    full = np.ones(len(touch.normal))
    return Coefficients(e * full, mu * full, beta0 * full)


def oblique(v_n: float, v_t: float) -> Touch:
    """Return spheres without spin that close at v_n along Y while b passes a toward +X at v_t."""
    normal = np.array([[0.0, 1.0, 0.0]])
    velocity = np.array([[[-v_t / 2, v_n / 2, 0.0], [v_t / 2, -v_n / 2, 0.0]]])
    return Touch(np.zeros((1, 3)), normal, velocity, np.zeros((1, 2, 3)))


def after(touch: Touch, velocity: Floats, spin: Floats) -> Touch:
    return replace(touch, velocity=velocity, spin=spin)


def momentum(touch: Touch, bodies: Bodies) -> Floats:
    return np.asarray((bodies.mass[:, None] * touch.velocity).sum(axis=1))


def angular_momentum(touch: Touch, place: Floats, bodies: Bodies) -> Floats:
    orbital = np.cross(place, bodies.mass[:, None] * touch.velocity)
    return np.asarray((orbital + bodies.inertia[:, None] * touch.spin).sum(axis=1))


def energy(touch: Touch, bodies: Bodies) -> Floats:
    moving = bodies.mass * (touch.velocity**2).sum(axis=-1)
    turning = bodies.inertia * (touch.spin**2).sum(axis=-1)
    return np.asarray((moving + turning).sum(axis=1) / 2)


def pressed(touch: Touch, law: Coefficients, bodies: Bodies, softness: float) -> Passage:
    ratio = grip(PLAIN, touch, law, bodies)
    return press(
        touch, law, ratio, bodies, softness=softness, outer=lambda x, v, w: np.zeros_like(v)
    )


NATURES = [PLAIN, Nature(mass_difference=0.1, inertia_excess=0.3), Nature(compliance=1.0)]


@pytest.mark.parametrize("nature", NATURES)
def test_an_instantaneous_contact_keeps_both_momenta_and_gains_no_energy(nature: Nature) -> None:
    bodies, touch = Bodies.of(NYLON, nature), touches()
    law = held(touch)
    later = after(touch, *strike(touch, law, grip(nature, touch, law, bodies), bodies))
    place = touch.point[:, None] + NYLON.radius_m * SIDES * touch.normal[:, None]
    np.testing.assert_allclose(momentum(later, bodies), momentum(touch, bodies), atol=1e-15)
    np.testing.assert_allclose(
        angular_momentum(later, place, bodies), angular_momentum(touch, place, bodies), atol=1e-15
    )
    assert (energy(later, bodies) <= energy(touch, bodies)).all()


def test_a_contact_in_time_keeps_both_momenta() -> None:
    bodies, touch = Bodies.of(NYLON, Nature(mass_difference=0.1)), touches()
    passage = pressed(touch, held(touch), bodies, softness=1.0)
    later = after(touch, passage.velocity, passage.spin)
    np.testing.assert_allclose(momentum(later, bodies), momentum(touch, bodies), atol=1e-15)
    np.testing.assert_allclose(
        angular_momentum(later, passage.position[-1], bodies),
        angular_momentum(touch, passage.position[0], bodies),
        atol=1e-8,
    )


def test_surfaces_leave_on_walton_s_two_lines() -> None:
    bodies, touch = Bodies.of(NYLON, PLAIN), touches()
    law = held(touch)
    later = after(touch, *strike(touch, law, grip(PLAIN, touch, law, bodies), bodies))
    slip = touch.slip(NYLON.radius_m)
    before = np.linalg.norm(slip, axis=1)
    along = np.einsum("si,si->s", later.slip(NYLON.radius_m), slip) / before
    v_n = touch.approach
    np.testing.assert_allclose(-later.approach, 0.74 * v_n)
    rolling, sliding = -0.5 * before, before - 0.08 * 1.74 * 3.5 * v_n
    np.testing.assert_allclose(along, np.maximum(rolling, sliding), atol=1e-13)
    assert 0.05 < (rolling > sliding).mean() < 0.95


def test_a_contact_in_time_becomes_the_instantaneous_one_as_it_gets_short() -> None:
    bodies, touch = Bodies.of(NYLON, PLAIN), touches(60)
    law = held(touch)
    velocity, spin = strike(touch, law, grip(PLAIN, touch, law, bodies), bodies)
    off = [
        np.abs(pressed(touch, law, bodies, softness).velocity - velocity).max()
        for softness in (0.02, 0.01)
    ]
    assert off[1] < 3e-3
    assert off[1] == pytest.approx(off[0] / 2, rel=0.15)
    np.testing.assert_allclose(pressed(touch, law, bodies, 0.01).spin, spin, atol=0.3)


@pytest.mark.parametrize(("v_n", "v_t"), [(1.736, 4.14), (1.0, 3.0)])
def test_a_contact_in_time_seems_less_elastic_as_mueller_and_poeschel_found(
    v_n: float, v_t: float
) -> None:
    bodies, touch = Bodies.of(NYLON, PLAIN), oblique(v_n, v_t)
    passage = pressed(touch, held(touch, e=1.0, mu=0.0), bodies, softness=1.0)
    apparent = -after(touch, passage.velocity, passage.spin).approach / v_n
    duration = float(hertz_duration(touch.approach, bodies, 1.0)[0])
    turn = v_t * duration / (2 * NYLON.diameter_m)
    assert apparent[0] == pytest.approx(1.0 - 2.0 * turn * v_t / v_n, abs=0.002)


def test_nylon_touches_as_long_as_hertz_says() -> None:
    bodies = Bodies.of(NYLON, PLAIN)
    stiffness = 4 / 3 * 3e9 / (2 * (1 - 0.4**2)) * (NYLON.diameter_m / 4) ** 0.5
    deepest = (5 * NYLON.mass_kg / 2 * 2.0**2 / (4 * stiffness)) ** 0.4
    found = hertz_duration(np.array([2.0]), bodies, 1.0)
    assert found[0] == pytest.approx(2.94 * deepest / 2.0)
    assert hertz_duration(np.array([2.0]), bodies, 0.25)[0] == pytest.approx(found[0] / 4)


def test_a_contact_in_time_restores_the_stated_restitution_head_on() -> None:
    bodies, touch = Bodies.of(NYLON, PLAIN), oblique(2.0, 0.0)
    passage = pressed(touch, held(touch), bodies, softness=1.0)
    later = after(touch, passage.velocity, passage.spin)
    assert -later.approach[0] / 2.0 == pytest.approx(0.74, abs=2e-4)


MAW = [
    *((0.25, 0.0562), (0.5, 0.0814), (1.0, 0.0154), (1.5, -0.3296), (2.0, -0.7442), (2.5, -1.0882)),
    *((3.0, -1.3345), (3.5, -1.4720), (4.0, -1.4864), (4.5, -1.3501), (5.0, -1.0), (7.0, 1.0)),
]
"""psi and f of elastic solid spheres with nu = 0.25, limit of full slip at 5."""


def test_elastic_bristles_follow_maw_barber_and_fawcett() -> None:
    psi, f = np.array(MAW).T
    mu = 0.08
    slip = psi * mu / STIFFNESS_RATIO
    full = np.ones_like(psi)
    ratio = impulse_ratio(slip, full, mu * full, 3.5)
    left = slip - 2.0 * 3.5 * ratio
    np.testing.assert_allclose(STIFFNESS_RATIO * left / mu, f, atol=0.01)


def test_compliance_leaves_contacts_that_slide_throughout_as_they_are() -> None:
    bodies, touch = Bodies.of(NYLON, PLAIN), touches()
    law = held(touch, e=1.0)
    sliding = np.linalg.norm(touch.slip(NYLON.radius_m), axis=1) > 0.6 * touch.approach
    ratio = grip(Nature(compliance=1.0), touch, law, bodies)
    np.testing.assert_allclose(ratio[sliding], 0.08, rtol=3e-4)


GAMMAS = [(0.0, 1.0), (0.05, 0.94440), (0.10, 0.89286), (0.20, 0.80097), (0.30, 0.72209)]
"""Damping and restitution, from the differential equation (Ramirez and others, 1999)."""


def test_viscoelastic_restitution_is_that_of_the_literature() -> None:
    gamma, e = np.array(GAMMAS).T
    np.testing.assert_allclose(restitution_of(gamma), e, atol=5e-5)


def test_viscoelastic_restitution_falls_with_speed_and_keeps_its_value_at_2_m_per_s() -> None:
    speed = np.array([0.5, 2.0, 8.0])
    full, quarter = softening(speed, 0.74, 1.0), softening(speed, 0.74, 0.25)
    assert full[1] == pytest.approx(1.0)
    assert full[0] > quarter[0] > 1.0 > quarter[2] > full[2]
    assert softening(speed, 0.74, 0.0).tolist() == [1.0, 1.0, 1.0]


def test_torsion_takes_spin_about_the_normal_alone_and_never_reverses_it() -> None:
    bodies, touch = Bodies.of(NYLON, PLAIN), touches()

    def relative(spin: Floats) -> Floats:
        return np.asarray(np.einsum("si,si->s", spin[:, 1] - spin[:, 0], touch.normal))

    for radius in (0.001, 1.0):
        nature = Nature(torsion_radius_m=radius)
        spin = twist(nature, touch, held(touch), touch.spin, bodies)
        given = spin - touch.spin
        np.testing.assert_allclose(np.cross(given, touch.normal[:, None]), 0.0, atol=1e-12)
        np.testing.assert_allclose(given.sum(axis=1), 0.0, atol=1e-12)
        share = relative(spin) / relative(touch.spin)
        assert (share > -1e-12).all()
        assert (share < 1.0).all()
    np.testing.assert_allclose(share, 0.0, atol=1e-12)


def test_torsion_of_a_millimetre_takes_the_spin_that_a_hand_calculation_gives() -> None:
    bodies, touch = Bodies.of(NYLON, PLAIN), oblique(2.0, 0.0)
    spin = np.array([[[0.0, 0.0, 0.0], [0.0, 100.0, 0.0]]])
    found = twist(Nature(torsion_radius_m=0.001), touch, held(touch), spin, bodies)
    # 3 pi / 16 x 0.08 x 1 mm x (1.74 x 2 m/s x 4.934 g) over I = 6.37e-7 kg m^2.
    assert found[0, 0, 1] == pytest.approx(1.271, abs=0.005)
    assert found[0, 1, 1] == pytest.approx(100.0 - 1.271, abs=0.005)
