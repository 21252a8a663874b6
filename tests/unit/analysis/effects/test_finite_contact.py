"""Finite contact against a damped Hertz contact integrated in time, and published values."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from analysis.collision.operator import Encounter
from analysis.effects.contact import finite_contact
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
)

EFFECT = finite_contact.EFFECT


def damping(e: float) -> float:
    """Return c of x'' = -x^1.5 - c x^0.25 x' that gives e.

    In x^(5/4) a linear damped oscillator that ends with its force: T. Schwager and T. Poeschel,
    Granular Matter 9, 465 (2007).
    """

    def excess(z: float) -> float:
        s = np.sqrt(1 - z**2)
        return float(np.exp(-z / s * (np.pi - np.arctan2(2 * z * s, 1 - 2 * z**2))) - e)

    return float(np.sqrt(5) * brentq(excess, 0.0, 0.9))


def pressed(met: Encounter) -> dict[str, np.ndarray]:
    """Integrate one head-on encounter along Y until the overlap is gone; sliding friction mu.

    Plane motion, Newton's equations of both centres and spins, forces at the point midway.
    """
    modulus = 3.0e9 / (2 * (1 - 0.4**2))
    stiffness = 4 / 3 * modulus * np.sqrt(NYLON.radius / 2)
    mass = NYLON.mass / 2
    mu = met.mu[0]
    damper = damping(met.e[0]) * np.sqrt(stiffness * mass)

    def rates(_: float, state: np.ndarray) -> np.ndarray:
        apart, velocity, spin = state[:2], state[2:4], state[4]
        distance = np.hypot(*apart)
        normal = apart / distance
        across = np.array([-normal[1], normal[0]])
        depth = max(2 * NYLON.radius - distance, 0.0)
        push = stiffness * depth**1.5 - damper * depth**0.25 * (velocity @ normal)
        push = max(push, 0.0)
        # Sum of both spins; anticlockwise ones carry the surfaces against the other's way.
        slip = velocity @ across - NYLON.radius * spin
        rub = -np.sign(slip) * mu * push
        force = push * normal + rub * across
        return np.array([*velocity, *(force / mass), -2 * rub * NYLON.radius / NYLON.inertia, spin])

    def parted(_: float, state: np.ndarray) -> float:
        return float(np.hypot(*state[:2]) - 2 * NYLON.radius)

    parted.terminal = True  # type: ignore[attr-defined]
    parted.direction = 1  # type: ignore[attr-defined]
    relative = met.before.velocity_b[0] - met.before.velocity_a[0]
    start = [0.0, 2 * NYLON.radius, relative[0], relative[1], 0.0, 0.0]
    found = solve_ivp(rates, (0, 1e-3), start, events=parted, rtol=1e-9, atol=1e-13, max_step=2e-6)
    end = found.y[:, -1]
    return {
        "time": found.t[-1],
        "apart": end[:2],
        "velocity": end[2:4],
        "spin": end[4],
        "turn": end[5],
    }


@pytest.mark.parametrize("e", [1.0, 0.85, 0.74])
@pytest.mark.parametrize(("v_n", "v_t"), [(2.0, 1.5), (1.2, 2.5), (1.0, 3.0)])
@pytest.mark.parametrize("mu", [0.0, 0.08])
def test_what_a_sliding_contact_leaves_is_that_of_the_integrated_one(
    e: float, v_n: float, v_t: float, mu: float
) -> None:
    met = head_on(v_n, v_t, law=(e, mu, 0.5))
    true = pressed(met)
    ours = after(EFFECT, 1.0, met)
    relative = (ours.after.velocity_b - ours.after.velocity_a)[0]
    hard = after(EFFECT, 0.0, met).after
    ignored = (hard.velocity_b - hard.velocity_a)[0]
    assert np.hypot(*(relative[:2] - true["velocity"])) < 2e-3
    assert np.hypot(*(ignored[:2] - true["velocity"])) > 10e-3
    assert ours.duration[0] == pytest.approx(true["time"], rel=0.015)
    spin = (ours.after.spin_a + ours.after.spin_b)[0, 2]
    assert spin == pytest.approx(true["spin"], abs=0.3)
    turn = (ours.turn_a + ours.turn_b)[0, 2]
    assert turn == pytest.approx(true["turn"], abs=1e-4)
    centres = 2 * NYLON.radius * Y + (ours.shift_b - ours.shift_a)[0]
    # A fraction of the duration off along the way is no error of the path that follows.
    late = centres[:2] + relative[:2] * (true["time"] - ours.duration[0])
    assert np.hypot(*(late - true["apart"])) < 2e-6


def test_published_elastic_values_of_the_apparent_restitution() -> None:
    """Two-dimensional soft spheres: 0.924 at v_n 1.736, v_t 4.14 and 0.923 at v_n 1, v_t 3."""
    found = []
    for v_n, v_t, share in ((1.736, 4.14, 0.924), (1.0, 3.0, 0.923)):
        met = head_on(v_n, v_t, law=(1.0, 0.0, 0.5))
        # The modulus behind the published pair: delta = (1 - e) v_n / (2 v_t) fixes the duration.
        wanted = (1 - share) * v_n / v_t**2 * 2 * NYLON.radius
        multiplier = wanted / finite_contact.hertz_time(met)[0]
        found.append(multiplier)
        assert separation(met, after(EFFECT, multiplier, met))[0] / v_n == pytest.approx(
            share, abs=4e-3
        )
    assert found[0] == pytest.approx(found[1], rel=0.05)
    assert found[0] == pytest.approx(1.0, abs=0.3)


def test_nylon_at_the_rigs_speeds_touches_for_125_to_250_microseconds() -> None:
    lasts = finite_contact.hertz_time(head_on([0.5, 1.3, 5.6]))
    assert lasts[1:] == pytest.approx([0.178e-3, 0.133e-3], rel=0.015)
    assert lasts[0] / lasts[2] == pytest.approx((5.6 / 0.5) ** 0.2)


def test_a_central_impact_only_takes_time() -> None:
    met = head_on(2.0)
    ours, hard = (after(EFFECT, a, met) for a in (1.0, 0.0))
    assert np.allclose(ours.after.velocity_b, hard.after.velocity_b, atol=1e-15)
    assert ours.duration[0] > 1e-4
    assert np.allclose(ours.shift_a, 0.0)


def test_the_line_of_centres_turns_with_the_passing_sphere() -> None:
    met = head_on(2.0, 1.5)
    ours = after(EFFECT, 1.0, met)
    line = 2 * NYLON.radius * Y + (ours.shift_b - ours.shift_a)[0]
    assert line @ X > 0
    assert np.linalg.norm(line) == pytest.approx(2 * NYLON.radius)


def test_momentum_is_kept_the_mass_centre_flies_on_and_energy_is_not_gained() -> None:
    met = any_encounters()
    ours = after(EFFECT, 1.0, met)
    assert np.allclose(momentum(ours.after, met.bodies), momentum(met.before, met.bodies))
    drift = (met.before.velocity_a + met.before.velocity_b) / 2 * ours.duration[:, None]
    assert np.allclose((ours.shift_a + ours.shift_b) / 2, drift)
    assert (energy(ours.after, met.bodies) <= energy(met.before, met.bodies) * (1 + 1e-9)).all()
