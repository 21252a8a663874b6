"""Forces and torques in flight: published sizes, hand-worked signs, and what air cannot do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.collision.operator import Body
from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import FlightEffect, Flying
from analysis.effects.flight import (
    buoyancy,
    drag,
    gravity_direction,
    gravity_value,
    magnus_lift,
    spin_decay,
    wind,
)

NYLON = Body.sphere(0.0254, 1150.0, 0.4)
G = 9.80665
DOWN, RIGHT, NEAR = np.eye(3)
speeds = st.tuples(*[st.floats(-8.0, 8.0)] * 3).map(np.array)
spins = st.tuples(*[st.floats(-300.0, 300.0)] * 3).map(np.array)
IN_AIR = (drag, magnus_lift, spin_decay, wind)


def flying(velocity: np.ndarray, spin: np.ndarray | None = None) -> Flying:
    return Flying(
        position=np.zeros(3),
        velocity=np.asarray(velocity, dtype=float),
        spin=np.zeros(3) if spin is None else np.asarray(spin, dtype=float),
        body=NYLON,
        gravity=G,
        air_density=1.2,
    )


def push(effect: FlightEffect, at: Flying, *values: float) -> np.ndarray:
    return effect.accelerate(at, np.array(values))[0]


def twist(effect: FlightEffect, at: Flying, *values: float) -> np.ndarray:
    return effect.accelerate(at, np.array(values))[1]


def test_a_ball_that_flies_right_with_backspin_is_lifted() -> None:
    # Backspin: the bottom, a radius below the centre, moves forward; w x (R down) is to the right.
    backspin = 100.0 * NEAR
    assert np.cross(backspin, DOWN) @ RIGHT > 0
    lift = push(magnus_lift.EFFECT, flying(5 * RIGHT, backspin), 1.0)
    assert lift @ DOWN < 0
    assert lift @ RIGHT == pytest.approx(0.0, abs=1e-15)
    assert lift @ NEAR == pytest.approx(0.0, abs=1e-15)


def test_lift_has_its_published_size_at_half_the_speed_on_the_surface() -> None:
    spin = 0.5 * 5.0 / NYLON.radius
    lift = np.linalg.norm(push(magnus_lift.EFFECT, flying(5 * RIGHT, spin * NEAR), 1.0))
    assert lift == pytest.approx(0.22, abs=0.01)
    # In 6 ms it turns into 1.3 mm/s.
    assert lift * 6e-3 == pytest.approx(1.3e-3, rel=0.02)


@pytest.mark.parametrize(
    ("ratio", "low", "high"),
    # A. M. Nathan (2008): 0.16 to 0.3 on baseballs between S = 0.2 and 0.5, with their scatter.
    [(0.2, 0.13, 0.25), (0.5, 0.22, 0.34)],
)
def test_the_lift_coefficient_lies_in_the_cloud_of_measurements(
    ratio: float, low: float, high: float
) -> None:
    assert low < magnus_lift.lift_coefficient(np.array(ratio)) < high


def test_a_ball_that_turns_about_its_line_of_flight_is_not_lifted() -> None:
    assert not push(magnus_lift.EFFECT, flying(5 * RIGHT, 300 * RIGHT), 1.0).any()


@given(velocity=speeds, spin=spins)
def test_lift_does_no_work(velocity: np.ndarray, spin: np.ndarray) -> None:
    lift = push(magnus_lift.EFFECT, flying(velocity, spin), 1.0)
    assert np.isfinite(lift).all()
    assert lift @ velocity == pytest.approx(0.0, abs=1e-9)


def test_still_air_lifts_and_brakes_no_ball_at_rest() -> None:
    for module in IN_AIR:
        effect = module.EFFECT
        values = effect.off.copy()
        values[0] = 1.0
        for part in effect.accelerate(flying(np.zeros(3)), values):
            assert not part.any()


def test_the_fall_in_air_is_slower_by_0_16_per_cent() -> None:
    loss = push(buoyancy.EFFECT, flying(np.zeros(3)), 1.0) @ DOWN / G
    assert loss == pytest.approx(-0.0016, abs=0.5e-4)


def test_a_ball_of_the_airs_density_floats() -> None:
    bubble = Flying(np.zeros(3), np.zeros(3), np.zeros(3), Body.sphere(0.1, 1.2, 0.4), G, 1.2)
    assert push(buoyancy.EFFECT, bubble, 1.0) @ DOWN == pytest.approx(-G)


def test_a_ball_without_weight_rises_with_twice_g_as_a_bubble_does() -> None:
    bubble = Flying(np.zeros(3), np.zeros(3), np.zeros(3), Body.sphere(0.1, 1e-9, 0.4), G, 1.2)
    assert push(buoyancy.EFFECT, bubble, 1.0) @ DOWN == pytest.approx(-3 * G, rel=1e-6)


@given(velocity=speeds, blow=speeds)
def test_drag_in_a_wind_is_drag_in_the_airs_own_frame(
    velocity: np.ndarray, blow: np.ndarray
) -> None:
    nominal = wind.NOMINAL_DRAG
    seen = push(wind.EFFECT, flying(velocity), nominal, *blow)
    own = push(drag.EFFECT, flying(velocity - blow), nominal)
    np.testing.assert_allclose(seen, own, atol=1e-12)


@given(velocity=speeds)
def test_without_wind_the_block_is_drag_alone(velocity: np.ndarray) -> None:
    seen = push(wind.EFFECT, flying(velocity), 0.3, 0.0, 0.0, 0.0)
    np.testing.assert_allclose(
        seen, push(drag.EFFECT, flying(velocity), 0.3), rtol=1e-14, atol=1e-300
    )


def test_half_a_metre_a_second_of_wind_changes_drag_at_5_m_per_s_by_0_06() -> None:
    against = push(wind.EFFECT, flying(5 * RIGHT), 0.42, 0.0, -0.5, 0.0)
    still = push(drag.EFFECT, flying(5 * RIGHT), 0.42)
    assert (against - still) @ RIGHT == pytest.approx(-0.06, abs=0.015)


def test_the_wind_can_be_seen_where_the_drag_is_off() -> None:
    for axis in range(3):
        blow = np.zeros(4)
        blow[1 + axis] = 1e-3
        assert push(wind.EFFECT, flying(5 * RIGHT), *blow)[axis] > 0


def test_the_air_takes_two_radians_per_second_from_a_fast_spin_in_a_second() -> None:
    rate = twist(spin_decay.EFFECT, flying(np.zeros(3), 200 * NEAR), 1.0)
    assert rate @ NEAR == pytest.approx(-2.0, abs=0.2)
    assert rate @ DOWN == 0.0
    assert rate @ RIGHT == 0.0


@pytest.mark.parametrize("spin", [10.0, 200.0])
def test_the_torque_has_the_published_coefficient(spin: float) -> None:
    reynolds = spin * NYLON.radius**2 / 1.5e-5
    coefficient = 6.45 / reynolds**0.5 + 32.1 / reynolds
    torque = coefficient * 1.2 / 2 * spin**2 * NYLON.radius**5
    rate = twist(spin_decay.EFFECT, flying(np.zeros(3), spin * DOWN), 1.0) @ DOWN
    assert -rate * NYLON.inertia == pytest.approx(torque)


@given(velocity=speeds, spin=spins)
def test_still_air_never_gives_energy(velocity: np.ndarray, spin: np.ndarray) -> None:
    at = flying(velocity, spin)
    for module in IN_AIR:
        values = module.EFFECT.off.copy()
        values[0] = 1.0
        linear, angular = module.EFFECT.accelerate(at, values)
        power = NYLON.mass * linear @ velocity + NYLON.inertia * angular @ spin
        assert power <= 1e-9


def test_an_excess_of_gravity_pulls_down_and_turns_nothing() -> None:
    at = flying(RIGHT, 50 * NEAR)
    np.testing.assert_array_equal(push(gravity_value.EFFECT, at, 0.02), 0.02 * DOWN)
    assert not twist(gravity_value.EFFECT, at, 0.02).any()


@given(right=st.floats(-0.5, 0.5), near=st.floats(-0.5, 0.5))
def test_tilted_gravity_keeps_its_amount(right: float, near: float) -> None:
    whole = G * DOWN + push(gravity_direction.EFFECT, flying(RIGHT), right, near)
    assert np.linalg.norm(whole) == pytest.approx(G)
    assert whole[1] / whole[0] == pytest.approx(np.tan(right), abs=1e-12)
    assert whole[2] / whole[0] == pytest.approx(np.tan(near), abs=1e-12)


def test_one_degree_of_tilt_pulls_sideways_by_0_17() -> None:
    side = push(gravity_direction.EFFECT, flying(RIGHT), np.radians(1.0), 0.0)
    assert side @ RIGHT == pytest.approx(0.17, abs=0.002)
    assert side @ NEAR == 0.0


@given(speeds, spins, st.floats(0.01, 2.0))
def test_an_effect_that_is_proportional_to_its_number_is_so_at_every_value(
    velocity: np.ndarray, spin: np.ndarray, value: float
) -> None:
    at = flying(velocity, spin)
    stated = [e for e in CATALOGUE if isinstance(e, FlightEffect) and e.proportional]
    assert drag.EFFECT in stated
    for effect in stated:
        assert len(effect.parameters) == 1
        assert push(effect, at, value) == pytest.approx(value * push(effect, at, 1.0), rel=1e-9)
        assert twist(effect, at, value) == pytest.approx(value * twist(effect, at, 1.0), rel=1e-9)
