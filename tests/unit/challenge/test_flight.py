from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from simulators.challenge.bodies import Bodies
from simulators.challenge.flight import acceleration, fly
from simulators.challenge.nature import Nature
from simulators.world.description import Environment, Sphere

Floats = NDArray[np.float64]

NYLON = Sphere()
WEIGHTLESS = Environment(gravity_m_per_s2=0.0)
PLACE = np.array([[[0.0, -0.1, 0.0], [0.0, 0.1, 0.0]]])
SPEED = np.array([[[0.0, 4.0, 0.0], [0.0, -2.0, 0.0]]])
STILL = np.zeros((1, 2, 3))
TIMES = np.array([[0.0, 0.004, 0.011]])
DENSITY = 1.2


def flown(
    nature: Nature,
    environment: Environment = WEIGHTLESS,
    *,
    place: Floats = PLACE,
    speed: Floats = SPEED,
    spin: Floats = STILL,
    times: Floats = TIMES,
) -> Floats:
    accelerate = acceleration(nature, Bodies.of(NYLON, nature), environment)
    return np.asarray(fly((place, speed, spin), times, accelerate)[0])


def test_a_plain_flight_is_galileo_s_parabola_both_ways() -> None:
    for times in (TIMES, -TIMES):
        t = times[0][:, None, None]
        expected = PLACE[0] + SPEED[0] * t + 0.5 * np.array([9.80665, 0.0, 0.0]) * t**2
        found = flown(Nature(), Environment(), times=times)
        np.testing.assert_allclose(found, expected, atol=1e-15)


def test_straight_flight_with_drag_follows_the_logarithm() -> None:
    rate = 0.5 * DENSITY * 0.45 * np.pi * NYLON.radius_m**2 / NYLON.mass_kg
    way = np.log1p(rate * 4.0 * TIMES[0]) / rate
    found = flown(Nature(drag_coefficient=0.45))
    np.testing.assert_allclose(found[:, 0, 1], -0.1 + way, atol=1e-13)
    np.testing.assert_array_equal(found[:, :, [0, 2]], 0.0)


def test_flight_with_drag_and_lift_runs_back_to_where_it_began() -> None:
    nature = Nature(drag_coefficient=0.45, lift=1.0, pull_m_per_s2=20.0)
    accelerate = acceleration(nature, Bodies.of(NYLON, nature), Environment())
    spin = np.array([[[100.0, 20.0, -60.0], [0.0, 0.0, 150.0]]])
    step = 1e-6
    ends = fly((PLACE, SPEED, spin), np.array([[0.01 - step, 0.01, 0.01 + step]]), accelerate)
    speed = (ends[:, 2] - ends[:, 0]) / (2 * step)
    back = fly((ends[:, 1], speed, spin), np.array([[-0.01]]), accelerate)
    np.testing.assert_allclose(back[:, 0], PLACE, atol=1e-10)


def test_wind_acts_as_still_air_seen_from_a_moving_laboratory() -> None:
    wind = np.array([0.3, 1.2, -0.7])
    nature = Nature(drag_coefficient=0.45, wind_m_per_s=(0.3, 1.2, -0.7))
    still = flown(replace(nature, wind_m_per_s=(0.0, 0.0, 0.0)), speed=SPEED - wind)
    moved = still + wind * TIMES[0][:, None, None]
    np.testing.assert_allclose(flown(nature), moved, atol=1e-14)


def test_backspin_lifts_by_the_coefficient_of_its_spin_ratio() -> None:
    # Toward +Y with the upper side (-X) turning back toward -Y: spin along +Z.
    spin = np.array([[[0.0, 0.0, 150.0], [0.0, 0.0, 0.0]]])
    ratio = NYLON.radius_m * 150.0 / 4.0
    area = np.pi * NYLON.radius_m**2
    expected = 0.5 * DENSITY * area * 16.0 / NYLON.mass_kg * ratio / (2.2 * ratio + 0.7)
    nature = Nature(lift=1.0)
    found = acceleration(nature, Bodies.of(NYLON, nature), WEIGHTLESS)(PLACE, SPEED, spin)
    np.testing.assert_allclose(found[0, 0], [-expected, 0.0, 0.0], atol=1e-15)
    np.testing.assert_array_equal(found[0, 1], 0.0)


def test_attraction_works_as_its_potential_says() -> None:
    pull, fade, gap = 20.0, 0.008, 0.01
    place = np.array([[[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]]) * (NYLON.radius_m + gap / 2)
    step = 1e-7
    times = np.array([[0.003 - step, 0.003, 0.003 + step]])
    found = flown(Nature(pull_m_per_s2=pull), place=place, speed=SPEED / 2, times=times)
    closing = float(((found[2] - found[0])[0, 1] - (found[2] - found[0])[1, 1]) / (2 * step))
    nearer = float(found[1, 1, 1] - found[1, 0, 1]) - NYLON.diameter_m
    work = 4 * pull * fade * (np.exp(-nearer / fade) - np.exp(-gap / fade))
    assert closing**2 == pytest.approx(3.0**2 + work, rel=1e-5)


def test_a_tilted_vertical_keeps_its_strength() -> None:
    nature = Nature(gravity_tilt_rad=(0.02, -0.01))
    found = acceleration(nature, Bodies.of(NYLON, nature), Environment())(PLACE, SPEED, STILL)
    assert np.linalg.norm(found[0, 0]) == pytest.approx(9.80665)
    assert found[0, 0, 1] / 9.80665 == pytest.approx(np.sin(0.02))
    assert found[0, 0, 2] / 9.80665 == pytest.approx(-np.sin(0.01))
