"""Effects on the normal restitution against published laws and hand-worked cases."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from analysis.effects.contact import (
    adhesion,
    restitution_drift,
    restitution_obliquity,
    restitution_plastic,
    restitution_viscoelastic,
    restitution_yield_knee,
    velocity_offset,
)
from analysis.effects.effect import ContactEffect
from tests.unit.analysis.effects.encounters import (
    after,
    any_encounters,
    energy,
    head_on,
    momentum,
    separation,
)

FAMILY = [
    (restitution_viscoelastic.EFFECT, 0.05),
    (restitution_plastic.EFFECT, 0.2),
    (restitution_yield_knee.EFFECT, 0.2),
    (restitution_obliquity.EFFECT, 0.05),
    (restitution_drift.EFFECT, 0.05),
    (velocity_offset.EFFECT, 0.02),
    (adhesion.EFFECT, 1e-3),
]


def restitution(
    effect: ContactEffect, value: float, approach: list[float], sliding: float = 0.0
) -> np.ndarray:
    met = head_on(approach, sliding)
    return separation(met, after(effect, value, met)) / np.array(approach)


@pytest.mark.parametrize(("effect", "value"), FAMILY, ids=[e.name for e, _ in FAMILY])
def test_momentum_is_kept_and_energy_never_gained(effect: ContactEffect, value: float) -> None:
    met = any_encounters()
    outcome = after(effect, value, met)
    assert np.allclose(momentum(outcome.after, met.bodies), momentum(met.before, met.bodies))
    assert (energy(outcome.after, met.bodies) <= energy(met.before, met.bodies)).all()


def test_viscoelastic_restitution_follows_a_damped_hertz_contact_over_the_rigs_speeds() -> None:
    """Kuwabara-Kono: x'' = -x^1.5 - 1.5 A sqrt(x) x', until the force is gone."""

    def rebound(speed: float, dissipation: float) -> float:
        def rates(_: float, state: np.ndarray) -> list[float]:
            root = np.sqrt(max(state[0], 0.0))
            return [state[1], -(root**3) - 1.5 * dissipation * root * state[1]]

        def force(_: float, state: np.ndarray) -> float:
            return float(state[0] + 1.5 * dissipation * state[1])

        force.terminal = True  # type: ignore[attr-defined]
        force.direction = -1  # type: ignore[attr-defined]
        found = solve_ivp(rates, (0, 50), [0, speed], events=force, rtol=1e-9, atol=1e-12)
        return -float(found.y[1, -1])

    assert rebound(1.0, 0.10 / 1.5) == pytest.approx(0.89286, abs=2e-5)
    speeds = np.array([0.7, 1.0, 2.0, 3.0, 4.0])
    true = np.array([rebound(v, 0.05) / v for v in speeds])
    drop = -(true[3] - true[1]) / true[2] / ((3.0**0.2 - 1) / 0.2)
    ours = restitution(restitution_viscoelastic.EFFECT, drop, list(speeds))
    assert ours / ours[2] == pytest.approx(true / true[2], abs=3e-4)


def test_plastic_restitution_has_johnsons_slope_of_minus_a_quarter() -> None:
    """e = 3.8 (Y / E*)^(1/2) [m* v^2 / (2 Y R*^3)]^(-1/8) (Johnson 1985, eq. 11.47)."""
    strength, modulus, mass, radius = 70e6, 1.8e9, 4.93e-3, 0.00635
    speeds = [0.8, 1.2, 2.0, 4.0]
    johnson = [
        3.8 * (strength / modulus) ** 0.5 * (mass * v**2 / 2 / strength / radius**3) ** -0.125
        for v in speeds
    ]
    ours = restitution(restitution_plastic.EFFECT, 0.25, speeds)
    assert ours / ours[2] == pytest.approx(np.array(johnson) / johnson[2], rel=1e-12)
    assert ours[2] == pytest.approx(0.74)


def test_plastic_restitution_ends_at_one_where_nothing_yields() -> None:
    assert restitution(restitution_plastic.EFFECT, 0.25, [0.1]) == pytest.approx([1.0])


def test_yield_knee_is_level_below_its_speed_and_a_power_above() -> None:
    ours = restitution(restitution_yield_knee.EFFECT, 0.25, [0.3, 1.0, 2.0, 4.0, 32.0])
    assert ours[:3] == pytest.approx([0.74] * 3)
    assert ours[3:] == pytest.approx([0.74 * 0.5**0.25, 0.74 * 0.5])


def test_yield_knee_tends_to_thorntons_power_far_above_yield() -> None:
    def thornton(r: float) -> float:
        tail = (r / (r + 2 * np.sqrt(6 / 5 - r**2 / 5))) ** 0.25
        return float(np.sqrt(6 * np.sqrt(3) / 5 * (1 - r**2 / 6)) * tail)

    assert thornton(1.0) == pytest.approx(1.0, abs=1e-3)
    knee = restitution_yield_knee.effect_at(0.02)
    ours = restitution(knee, 0.25, [2.0, 4.0])
    assert ours[1] / ours[0] == pytest.approx(thornton(0.005) / thornton(0.01), rel=2e-3)


def test_yield_knees_cover_the_believed_yield_speeds() -> None:
    speeds = sorted(restitution_yield_knee.OTHER_YIELD_SPEEDS)
    assert speeds[0] <= 0.74
    assert speeds[-1] >= 2.0
    assert len(restitution_yield_knee.EFFECT.variants) == len(speeds)


def test_adhesion_takes_most_from_the_slowest_impacts() -> None:
    """By hand: v_n' = 0.74 v_n - 0.01 / v_n."""
    ours = restitution(adhesion.EFFECT, 0.01, [0.5, 1.0, 2.0])
    assert ours == pytest.approx([0.70, 0.73, 0.7375])


def test_adhesion_of_nylon_cannot_be_seen_on_this_rig() -> None:
    """v_st = 1.84 (Gamma^5 R*^4 / (m*^3 E*^2))^(1/6), Gamma = 0.08 J/m^2 (Thornton, Ning 1998)."""
    sticking = 1.84 * (0.08**5 * 0.00635**4 / (4.93e-3**3 * 1.8e9**2)) ** (1 / 6)
    largest = adhesion.EFFECT.parameters[0].plausible[1]
    assert sticking == pytest.approx(1e-4, rel=0.5)
    assert sticking**2 < largest
    met = head_on(0.5)
    lost = separation(met, after(adhesion.EFFECT, 0.0, met)) - separation(
        met, after(adhesion.EFFECT, largest, met)
    )
    assert 0 < lost < 1e-5


def test_obliquity_acts_on_the_ratio_of_sliding_to_approach_up_to_three() -> None:
    ours = [
        restitution(restitution_obliquity.EFFECT, -0.05, [1.0], sliding)[0]
        for sliding in (0.0, 1.0, 2.0, 3.0, 6.0)
    ]
    shares = np.array([1.0, 0.95, 0.90, 0.85, 0.85])
    assert ours == pytest.approx(0.74 * shares)


def test_velocity_offset_is_the_same_at_every_speed() -> None:
    met = head_on([0.5, 1.0, 3.0])
    apart = separation(met, after(velocity_offset.EFFECT, 0.02, met))
    assert apart == pytest.approx(0.74 * np.array([0.5, 1.0, 3.0]) + 0.02)


def test_restitution_drifts_from_half_below_to_half_above() -> None:
    ours = restitution(restitution_drift.EFFECT, 0.10, [2.0, 2.0, 2.0])
    assert ours == pytest.approx([0.703, 0.74, 0.777])
