"""From mouths to first touch: parabolas and touches worked by hand, and derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.collision.operator import Body, States
from analysis.launch.muzzle import LaunchLaw, Muzzle
from analysis.launch.touch import (
    Ground,
    observed_touch,
    states_of,
    touch,
    touch_by_state,
    traced_back,
    tracks_meet,
)
from analysis.model.predict.state import ShotStates

G = 9.80665
R = 0.0127
SPHERE = Body.sphere(2 * R, 1150.0, 0.4)
GROUND = Ground((SPHERE, SPHERE), G)
WEIGHTLESS = Ground((SPHERE, SPHERE), 0.0)
LAW = LaunchLaw(0.09, 0.09, mouth=0.08, push=0.02)


def muzzle(
    speed: tuple[float, float] = (2.0, 2.0),
    offset: tuple[float, float] = (0.0, 0.0),
    lag: float = 0.0,
    slope: float = 0.0,
) -> Muzzle:
    return Muzzle(
        speed=np.array([speed]),
        slope=np.full((1, 2, 2), slope),
        spin=np.arange(6.0).reshape(1, 2, 3),
        offset_m=np.array([offset]),
        height_m=np.zeros((1, 2)),
        lag_s=np.array([lag]),
    )


def test_equal_spheres_meet_head_on_in_the_middle() -> None:
    row = touch(muzzle(), LAW, WEIGHTLESS)[0]
    assert row[:6] == pytest.approx([0, 2, 0, 0, -2, 0])
    assert row[6:12] == pytest.approx(np.arange(6.0))
    assert row[12:] == pytest.approx(np.zeros(5), abs=1e-12)


def test_both_fall_for_the_way_from_the_mouth() -> None:
    row = touch(muzzle(), LAW, GROUND)[0]
    time = (0.08 - R) / 2.0
    assert row[[0, 3]] == pytest.approx([G * time] * 2)
    assert row[12] == pytest.approx(G * time**2 / 2)


def test_a_lag_moves_the_contact_toward_b_by_half_of_the_way_flown_in_it() -> None:
    lag = 1e-3
    row = touch(muzzle(lag=lag), LAW, WEIGHTLESS)[0]
    assert row[13] == pytest.approx(2.0 * lag / 2)


def test_a_lag_changes_the_offset_by_the_difference_of_the_falls() -> None:
    lag, time = 1e-3, (0.08 - R) / 2.0
    row = touch(muzzle(lag=lag), LAW, GROUND)[0]
    first, second = time + lag / 2, time - lag / 2
    assert row[15] * 2 * R == pytest.approx(G / 2 * (second**2 - first**2), rel=1e-3)


def test_the_slower_sphere_is_met_on_its_own_side() -> None:
    # The push takes as long as its way at the muzzle's speed: a runs 0.1 at 1, b 0.1 at 3 m/s.
    row = touch(muzzle(speed=(1.0, 3.0)), LAW, WEIGHTLESS)[0]
    together = (2 * 0.1 - 2 * R) / 4.0
    assert row[13] == pytest.approx(-0.1 + together + R)


@pytest.mark.parametrize("offset", [(0.01, 0.0), (0.0, -0.006), (0.012, 0.009)])
def test_the_normal_follows_the_offset(offset: tuple[float, float]) -> None:
    row = touch(muzzle(offset=offset), LAW, WEIGHTLESS)[0]
    assert row[15:] == pytest.approx(np.array(offset) / (2 * R))


speeds = st.tuples(st.floats(0.8, 5.0), st.floats(0.8, 5.0))


@given(speeds, st.floats(-0.012, 0.02), st.floats(-2e-3, 2e-3), st.floats(-0.02, 0.02))
def test_centres_are_a_diameter_apart_where_the_parabolas_say(
    speed: tuple[float, float], offset: float, lag: float, slope: float
) -> None:
    """Run both spheres back from the touch: they must leave their mouths as they were sent."""
    sent = muzzle(speed=speed, offset=(offset, 0.003), lag=lag, slope=slope)
    row = touch(sent, LAW, GROUND)
    if not tracks_meet(row)[0]:
        return
    state = states_of(row, np.zeros(1))
    back = []
    for side, velocity in ((-R, state.before.velocity_a[0]), (R, state.before.velocity_b[0])):
        centre = state.point[0] + side * state.normal[0]
        flown = (0.08 - abs(centre[1])) / abs(velocity[1])
        if np.sign(centre[1]) != np.sign(side):
            flown = (0.08 + abs(centre[1])) / abs(velocity[1])
        mouth = centre - velocity * flown + np.array([G, 0, 0]) * flown**2 / 2
        back.append((mouth, velocity[0] - G * flown, flown + 0.02 / abs(velocity[1])))
    (mouth_a, down_a, since_a), (mouth_b, down_b, since_b) = back
    assert mouth_b[0] - mouth_a[0] == pytest.approx(offset, abs=1e-9)
    assert mouth_b[2] - mouth_a[2] == pytest.approx(0.003, abs=1e-9)
    assert [down_a, down_b] == pytest.approx(slope * np.array(speed), abs=1e-9)
    assert since_a - since_b == pytest.approx(lag, abs=1e-9)


@given(speeds, st.floats(-0.012, 0.02), st.floats(-2e-3, 2e-3), st.floats(-0.02, 0.02))
def test_tracing_back_undoes_the_flight(
    speed: tuple[float, float], offset: float, lag: float, slope: float
) -> None:
    sent = muzzle(speed=speed, offset=(offset, 0.003), lag=lag, slope=slope)
    row = touch(sent, LAW, GROUND)
    if tracks_meet(row)[0]:
        assert traced_back(row, LAW, GROUND).row == pytest.approx(sent.row, abs=1e-9)


def test_tracks_that_pass_each_other_are_known() -> None:
    passing = touch(muzzle(offset=(0.03, 0.0)), LAW, WEIGHTLESS)
    assert not tracks_meet(passing)[0]
    assert np.isfinite(passing).all()


def random_states(shots: int) -> ShotStates:
    rng = np.random.default_rng(4)
    normal = rng.normal(0, 0.4, (shots, 3))
    normal[:, 1] = 1.0
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return ShotStates(
        time_s=rng.uniform(0.01, 0.012, shots),
        point=rng.normal(0, 1e-3, (shots, 3)),
        normal=normal,
        before=States(*rng.normal(0, 2, (4, shots, 3))),
        rotation=np.tile(np.eye(3), (shots, 2, 1, 1)),
    )


def test_states_come_back_from_their_touches() -> None:
    states = random_states(5)
    again = states_of(observed_touch(states), states.time_s)
    assert again.normal == pytest.approx(states.normal)
    assert again.point == pytest.approx(states.point)
    assert again.before.spin_b == pytest.approx(states.before.spin_b)


def test_the_derivative_by_the_state_is_that_of_a_small_move() -> None:
    states = random_states(4)
    derivative = touch_by_state(states)
    for k in range(24):
        step = np.zeros((4, 24))
        step[:, k] = 1e-6
        moved = (observed_touch(states.moved(step)) - observed_touch(states)) / 1e-6
        assert derivative[:, :, k] == pytest.approx(moved, abs=2e-6)
