"""The wobble of a loaded sphere, against SciPy's rotations and kinematics worked by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from analysis.effects.contact.mass_offset import EFFECT
from analysis.effects.effect import Turning

SPIN, OFFSET = 200.0, 1e-4
TIMES = np.arange(-8, 9) * 1e-3
lengths = st.floats(-2e-4, 2e-4)


def turning(axis: np.ndarray, start: Rotation) -> Turning:
    """Return both spheres turning at SPIN about an axis of the rig, at rest in place."""
    turned = (Rotation.from_rotvec(SPIN * TIMES[:, None] * axis) * start).as_matrix()
    rotation = np.stack([turned, turned], axis=1)[None]
    at_touch = np.tile(start.as_matrix(), (1, 2, 1, 1))
    return Turning(np.zeros((1, len(TIMES), 2, 3)), rotation, at_touch)


def test_off_changes_nothing() -> None:
    seen = turning(np.eye(3)[2], Rotation.random(random_state=1))
    assert np.array_equal(EFFECT.displace(seen, EFFECT.off), seen.position)


def test_a_centre_off_the_axis_circles_at_the_spin_s_speed() -> None:
    seen = turning(np.eye(3)[2], Rotation.identity())
    values = np.array([OFFSET, 0, 0, 0, OFFSET, 0])
    a, b = np.moveaxis(EFFECT.displace(seen, values)[0], 1, 0)
    angle = SPIN * TIMES
    assert a == pytest.approx(OFFSET * np.stack([np.cos(angle) - 1, np.sin(angle), 0 * angle], 1))
    assert b == pytest.approx(OFFSET * np.stack([-np.sin(angle), np.cos(angle) - 1, 0 * angle], 1))
    # 0.1 mm at 200 rad/s: 0.02 m/s.
    speed = np.linalg.norm(np.gradient(a, TIMES[1] - TIMES[0], axis=0)[1:-1], axis=1)
    assert speed == pytest.approx(0.02, rel=0.01)


@given(st.tuples(*[lengths] * 6).map(np.array), st.integers(0, 100))
def test_the_outlines_touch_where_they_touched(values: np.ndarray, seed: int) -> None:
    axis = np.array([0.6, 0.0, 0.8])
    seen = turning(axis, Rotation.random(random_state=seed))
    at_touch = EFFECT.displace(seen, values)[0, np.flatnonzero(TIMES == 0.0)[0]]
    assert at_touch == pytest.approx(np.zeros((2, 3)), abs=1e-18)


@given(lengths, st.integers(0, 100))
def test_an_offset_along_the_spin_is_not_seen(length: float, seed: int) -> None:
    start = Rotation.random(random_state=seed)
    axis = np.array([0.0, 0.6, 0.8])
    along = start.inv().apply(axis) * length
    moved = EFFECT.displace(turning(axis, start), np.concatenate([along, along]))
    assert np.abs(moved).max() < 1e-16


def test_its_derivative_is_that_of_the_turning() -> None:
    seen = turning(np.eye(3)[0], Rotation.random(random_state=7))
    for k, parameter in enumerate(EFFECT.parameters):
        step = np.zeros(6)
        step[k] = parameter.step
        derivative = EFFECT.displace(seen, step) / parameter.step
        sphere, axis = divmod(k, 3)
        expected = np.zeros_like(derivative)
        expected[0, :, sphere] = (seen.rotation[0, :, sphere] - seen.at_touch[0, sphere])[
            :, :, axis
        ]
        assert derivative == pytest.approx(expected, abs=1e-12)


def test_offsets_are_recovered_from_tracks_by_least_squares() -> None:
    rng = np.random.default_rng(3)
    seen = turning(np.array([0.0, 0.8, 0.6]), Rotation.random(random_state=5))
    true = rng.uniform(-1e-4, 1e-4, 6)
    sigma = 3e-5
    measured = EFFECT.displace(seen, true) + sigma * rng.normal(size=seen.position.shape)
    columns = [EFFECT.displace(seen, unit * 1e-4).reshape(-1) / 1e-4 for unit in np.eye(6)]
    design = np.stack(columns, axis=1) / sigma
    covariance = np.linalg.pinv(design.T @ design)
    found = covariance @ design.T @ (measured.reshape(-1) / sigma)
    # Along the spin's axis nothing is seen: only the part across it is compared.
    difference = design @ (found - true)
    assert (difference**2).sum() < 16
