"""The first guess of a shot is near enough for a fit to find the rest, and is not thrown off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.model.predict.start import first_states
from analysis.model.predict.state import ShotStates
from tests.unit.analysis.model.hard_spheres import Drawn, campaign, draw

SHOTS = 60


@pytest.fixture(scope="module")
def drawn() -> Drawn:
    return draw(np.random.default_rng(21), SHOTS)


@pytest.fixture(scope="module")
def states() -> ShotStates:
    return first_states(campaign(SHOTS, 21))


def spins(states: ShotStates) -> np.ndarray:
    return np.stack([states.before.spin_a, states.before.spin_b], axis=1)


def test_the_instant_of_contact_is_found_far_below_the_time_between_frames(
    states: ShotStates, drawn: Drawn
) -> None:
    error = np.abs(states.time_s - drawn.contact_s)
    assert np.median(error) < 2e-5
    assert error.max() < 3e-4


def test_the_normal_points_from_a_to_b_where_the_spheres_touched(
    states: ShotStates, drawn: Drawn
) -> None:
    cosine = (states.normal * drawn.normal).sum(axis=1)
    assert np.median(np.arccos(np.minimum(cosine, 1))) < 0.01
    assert cosine.min() > np.cos(0.2)


def test_velocities_before_contact_carry_the_fall_up_to_it(
    states: ShotStates, drawn: Drawn
) -> None:
    # A straight line through 12 frames, 2e-5 m each: 1.7e-3 m/s at its slope.
    found = np.stack([states.before.velocity_a, states.before.velocity_b], axis=1)
    assert np.abs(found - drawn.velocity).max() < 6 * 1.7e-3


def test_spins_are_near_the_truth(states: ShotStates, drawn: Drawn) -> None:
    # Median of 11 turns of 0.011 rad in 1 ms, neighbours sharing a frame: below 6 rad/s.
    error = spins(states) - drawn.spin
    assert np.sqrt((error**2).mean()) < 6
    assert np.abs(error).max() < 30


def test_one_slipped_orientation_does_not_move_a_spin(drawn: Drawn) -> None:
    data = campaign(SHOTS, 21)
    rotation = data.rotation.copy()
    rotation[:, 5] = Rotation.from_rotvec([0.0, 2.5, 0.0]).as_matrix() @ rotation[:, 5]
    error = spins(first_states(replace(data, rotation=rotation))) - drawn.spin
    assert np.sqrt((error**2).mean()) < 8


def test_a_sphere_without_orientations_starts_without_spin(drawn: Drawn) -> None:
    data = campaign(SHOTS, 21)
    sigma = data.rotation_sigma.copy()
    sigma[:, :, 1] = np.inf
    states = first_states(replace(data, rotation_sigma=sigma))
    assert np.array_equal(states.before.spin_b, np.zeros((SHOTS, 3)))
    assert np.array_equal(states.rotation[:, 1], np.tile(np.eye(3), (SHOTS, 1, 1)))
    assert np.sqrt(((states.before.spin_a - drawn.spin[:, 0]) ** 2).mean()) < 6


def test_frames_that_show_one_sphere_only_do_not_enter(drawn: Drawn) -> None:
    data = campaign(SHOTS, 21)
    sigma, position = data.position_sigma.copy(), data.position.copy()
    sigma[:, ::4, 0] = np.inf
    position[:, ::4, 0] = 0.0
    states = first_states(replace(data, position=position, position_sigma=sigma))
    assert np.median(np.abs(states.time_s - drawn.contact_s)) < 3e-5
