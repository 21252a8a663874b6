"""Effects of the launch: what each does to one shot, worked by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.effects.catalogue import CATALOGUE, LAUNCH_CATALOGUE
from analysis.effects.effect import LaunchEffect
from analysis.effects.launch import (
    launch_delay,
    pressure_friction,
    pressure_hysteresis,
    pressure_leak,
    slide_backlash,
    tube_spin,
)
from analysis.launch.muzzle import Charge, LaunchLaw, Muzzle, push

EVERY = pytest.mark.parametrize("effect", LAUNCH_CATALOGUE, ids=lambda effect: effect.name)
LAW = LaunchLaw(gain_a=0.09, gain_b=0.16, tilt_a_x=0.01, shift_x=1e-3, height_z=2e-3)


def charge() -> Charge:
    """Return two shots: 25 and 100 kPa, a fall of both pressures and a move up of the slide."""
    return Charge(
        law=LAW,
        pressure_kpa=np.array([[100.0, 25.0], [25.0, 100.0]]),
        offset_m=np.array([0.004, 0.006]),
        delay_s=np.array([0.0, 1e-3]),
        pressure_step=np.array([[0.0, 0.0], [-1.0, 1.0]]),
        slide_step=np.array([0.0, 1.0]),
        waited_s=np.array([0.0, 10.0]),
        radius_m=np.array([0.0127, 0.0127]),
    )


def launched(effect: LaunchEffect, *values: float) -> Muzzle:
    return effect.wrap(push, np.array(values))(charge())


def test_a_pusher_without_losses_turns_work_into_speed() -> None:
    muzzle = push(charge())
    assert muzzle.speed == pytest.approx(np.array([[3.0, 2.0], [1.5, 4.0]]))
    assert np.array_equal(muzzle.spin, np.zeros((2, 2, 3)))
    assert muzzle.offset_m[:, 0] == pytest.approx([0.005, 0.007])
    assert muzzle.slope[:, 0, 0] == pytest.approx([0.01, 0.01])
    assert muzzle.height_m[:, 1] == pytest.approx([2e-3, 2e-3])
    assert muzzle.lag_s == pytest.approx([0.0, 1e-3])


@EVERY
def test_off_changes_nothing(effect: LaunchEffect) -> None:
    assert np.array_equal(launched(effect, *effect.off).row, push(charge()).row)


@EVERY
def test_it_says_what_it_is(effect: LaunchEffect) -> None:
    assert all([effect.name, effect.title, effect.formula, effect.source, effect.gives_away])
    assert effect.stage == "launch"
    for parameter in effect.parameters:
        low, high = parameter.plausible
        assert all([parameter.symbol, parameter.unit, parameter.meaning])
        assert low <= parameter.off < high
        assert not parameter.one_sided or low == parameter.off


def test_names_are_their_own_and_what_confuses_is_there() -> None:
    names = [effect.name for effect in LAUNCH_CATALOGUE]
    assert len({*names, *(effect.name for effect in CATALOGUE)}) == len(names) + len(CATALOGUE)
    for effect in LAUNCH_CATALOGUE:
        assert set(effect.confused_with) <= set(names) - {effect.name}


@EVERY
def test_its_derivative_does_not_hang_on_the_step(effect: LaunchEffect) -> None:
    def derivative(k: int, step: float) -> np.ndarray:
        values = effect.off.copy()
        values[k] += step
        return (launched(effect, *values).row - push(charge()).row) / step

    for k, parameter in enumerate(effect.parameters):
        full, half = derivative(k, parameter.step), derivative(k, parameter.step / 2)
        assert np.abs(full).max() > 0
        assert np.abs(full - half).max() < 1e-3 * np.abs(full).max()


def test_friction_takes_its_pressure_from_each_pusher() -> None:
    # 0.09 (100 - 19) = 2.7^2, 0.16 (25 - 9) = 1.6^2.
    speed = launched(pressure_friction.EFFECT, 19.0, 9.0).speed
    assert speed[0] == pytest.approx([2.7, 1.6])


def test_friction_above_the_pressure_leaves_the_sphere_all_but_still() -> None:
    speed = launched(pressure_friction.EFFECT, 30.0, 30.0).speed
    assert 0 < speed[1, 0] < 0.02
    assert np.isfinite(speed).all()


def test_hysteresis_lifts_the_speed_after_a_rise_and_lowers_it_after_a_fall() -> None:
    speed = launched(pressure_hysteresis.EFFECT, 0.02).speed
    assert speed == pytest.approx(np.array([[3.0, 2.0], [1.5 * 0.98, 4.0 * 1.02]]))


def test_a_leak_of_one_per_cent_a_second_takes_a_tenth_of_the_exponent_in_ten() -> None:
    speed = launched(pressure_leak.EFFECT, 0.01).speed
    assert speed[0] == pytest.approx([3.0, 2.0])
    assert speed[1] == pytest.approx(np.array([1.5, 4.0]) * np.exp(-0.05))


def test_a_late_valve_adds_to_the_delay_that_was_set() -> None:
    assert launched(launch_delay.EFFECT, 5e-4).lag_s == pytest.approx([5e-4, 1.5e-3])


def test_a_sphere_that_rolls_has_no_slip_at_its_lowest_point() -> None:
    muzzle = launched(tube_spin.EFFECT, 1.0)
    velocity = muzzle.speed[..., None] * np.array([[0, 1.0, 0], [0, -1.0, 0]])
    lowest = np.array([0.0127, 0.0, 0.0])
    assert velocity + np.cross(muzzle.spin, lowest) == pytest.approx(np.zeros((2, 2, 3)))
    assert muzzle.spin[0, 0, 2] == pytest.approx(-3.0 / 0.0127)


def test_backlash_shifts_the_offset_by_half_of_it_after_a_move() -> None:
    offset = launched(slide_backlash.EFFECT, 1e-4).offset_m[:, 0]
    assert offset == pytest.approx([0.005, 0.007 + 5e-5])


@given(st.floats(0, 20), st.floats(-0.03, 0.03))
def test_effects_wrap_one_another_in_any_order_where_they_act_apart(p: float, h: float) -> None:
    friction, hysteresis = pressure_friction.EFFECT.wrap, pressure_hysteresis.EFFECT.wrap
    pressures, share = np.array([p, p]), np.array([h])
    one = friction(hysteresis(push, share), pressures)(charge())
    other = hysteresis(friction(push, pressures), share)(charge())
    assert one.row == pytest.approx(other.row)


@EVERY
def test_it_needs_no_more_than_it_reads(effect: LaunchEffect) -> None:
    """An effect of history does nothing where there is none."""
    first = replace(
        charge(), pressure_step=np.zeros((2, 2)), slide_step=np.zeros(2), waited_s=np.zeros(2)
    )
    moved = effect.wrap(push, effect.off + 1e-3)(first)
    remembers = effect.name in {"pressure-hysteresis", "pressure-leak", "slide-backlash"}
    assert np.array_equal(moved.row, push(first).row) == remembers
