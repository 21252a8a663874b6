"""A sphere on a plate, held against an integration that shares no code, and published limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from analysis.collision.damping import damping, restitution
from analysis.collision.force_law import KUWABARA_KONO, TSUJI, ForceLaw
from analysis.collision.lasting import Stiffness, lasting
from analysis.collision.operator import Body, Encounter, Outcome, States
from simulators.challenge import drops
from simulators.challenge.drops import Drop, bounce

COUNT = 8


def onto_plate(drop: Drop, seed: int) -> Encounter:
    rng = np.random.default_rng(seed)
    normal = np.tile(drop.normal, (COUNT, 1))
    velocity = rng.normal(0.0, 1.0, (COUNT, 3))
    velocity += (rng.uniform(0.5, 4.0, COUNT) - velocity @ drop.normal)[:, None] * normal
    still = np.zeros((COUNT, 3))
    lost = restitution(np.array(drop.damping), KUWABARA_KONO if drop.viscous else TSUJI)
    return Encounter(
        before=States(velocity, still, rng.normal(0.0, 60.0, (COUNT, 3)), still),
        normal=normal,
        bodies=(
            Body.sphere(2 * drop.radius_m, drop.density_kg_per_m3, 0.4),
            Body.plate(),
        ),
        e=np.full(COUNT, float(lost)),
        mu=np.full(COUNT, drop.friction),
        beta0=np.zeros(COUNT),
        covariates={},
        gravity=drops.GRAVITY,
    )


def lasted(drop: Drop, met: Encounter) -> Outcome:
    law = ForceLaw(KUWABARA_KONO if drop.viscous else TSUJI, "elongation")
    stiffness = Stiffness(drop.duration_s, drop.stiffness_ratio, drop.tangential_damping)
    return lasting(met, law, stiffness)


@pytest.mark.parametrize("viscous", [False, True])
@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.1, -0.05)])
def test_a_sphere_leaves_a_plate_as_an_integration_of_its_own_has_it(
    viscous: bool, tilt: tuple[float, float]
) -> None:
    drop = Drop(viscous=viscous, tilt=tilt)
    met = onto_plate(drop, 5)
    found = lasted(drop, met)
    for k in range(COUNT):
        start = drops.Body(
            -drop.radius_m * drop.normal,
            met.before.velocity_a[k],
            met.before.spin_a[k],
            Rotation.identity(),
        )
        left, took = bounce(drop, start)
        assert found.after.velocity_a[k] == pytest.approx(left.velocity, abs=2e-4)
        assert found.after.spin_a[k] == pytest.approx(left.spin, abs=0.05)
        assert found.duration[k] == pytest.approx(took, rel=1e-3)
        assert found.shift_a[k] == pytest.approx(left.place - start.place, abs=2e-6)
        assert found.turn_a[k] == pytest.approx(left.turned.as_rotvec(), abs=2e-4)


def test_viscous_losses_on_a_plate_go_with_the_fifth_root_of_the_speed() -> None:
    # 1 - e ~ v^(1/5) where losses are small: G. Kuwabara and K. Kono (1987).
    drop = Drop(viscous=True, damping=0.02)
    met, speeds = onto_plate(drop, 6), np.geomspace(0.05, 10.0, COUNT)
    still = np.zeros((COUNT, 3))
    straight = replace(
        met, before=States(speeds[:, None] * drop.normal, still, still, still), gravity=0.0
    )
    lost = 1.0 + (lasted(drop, straight).after.velocity_a @ drop.normal) / speeds
    slope = np.polyfit(np.log(speeds), np.log(lost), 1)[0]
    assert slope == pytest.approx(0.2, abs=0.01)


def test_tsujis_restitution_is_the_same_at_every_speed_and_lasts_with_its_fifth_root() -> None:
    drop = Drop(damping=0.25)
    met, speeds = onto_plate(drop, 6), np.geomspace(0.05, 10.0, COUNT)
    still = np.zeros((COUNT, 3))
    straight = replace(
        met, before=States(speeds[:, None] * drop.normal, still, still, still), gravity=0.0
    )
    found = lasted(drop, straight)
    left = -(found.after.velocity_a @ drop.normal) / speeds
    assert left == pytest.approx(np.full(COUNT, left[0]), abs=1e-5)
    slope = np.polyfit(np.log(speeds), np.log(found.duration), 1)[0]
    assert slope == pytest.approx(-0.2, abs=1e-4)


def test_unlike_spheres_part_as_a_solver_of_differential_equations_has_it() -> None:
    """Head on, where the overlap alone counts: m* x'' = -k x^1.5 - c x^0.5 x'."""
    small, large = Body.sphere(0.01, 7800.0, 0.4), Body.sphere(0.03, 1150.0, 0.4)
    mass, lasts, speed = 1.0 / (1.0 / small.mass + 1.0 / large.mass), 1e-4, 2.0
    stiffness = mass * (3.21804 / lasts) ** 2.5
    damped = float(damping(np.array(0.8), KUWABARA_KONO))
    depth = (mass * speed**2 / stiffness) ** 0.4
    dashpot = damped * stiffness * depth / speed

    def rates(_: float, y: np.ndarray) -> list[float]:
        x = max(float(y[0]), 0.0)
        return [y[1], -(stiffness * x**1.5 + dashpot * x**0.5 * y[1]) / mass]

    def pulls(_: float, y: np.ndarray) -> float:
        return float(stiffness * max(float(y[0]), 0.0) + dashpot * y[1])

    pulls.terminal, pulls.direction = True, -1.0  # type: ignore[attr-defined]
    solved = solve_ivp(
        rates, (0.0, 3 * lasts), [0.0, speed], "LSODA", events=pulls, rtol=1e-10, atol=1e-15
    )
    still = np.zeros((1, 3))
    along = np.array([[0.0, 1.0, 0.0]])
    met = Encounter(
        before=States(speed * along, still, still, still),
        normal=along,
        bodies=(small, large),
        e=np.array([0.8]),
        mu=np.zeros(1),
        beta0=np.zeros(1),
        covariates={},
    )
    after = lasting(met, ForceLaw(KUWABARA_KONO, "elongation"), Stiffness(lasts, 0.3, 0.05)).after
    apart = float(after.velocity_b[0, 1] - after.velocity_a[0, 1])
    assert apart == pytest.approx(-float(solved.y[1, -1]), abs=1e-3)
    assert apart == pytest.approx(0.8 * speed, abs=1e-3)
    momentum = small.mass * after.velocity_a + large.mass * after.velocity_b
    assert momentum == pytest.approx(small.mass * speed * along, rel=1e-9)
