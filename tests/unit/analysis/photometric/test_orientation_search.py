"""How a sphere stands, found without a hint, against how it was drawn."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.motion.rotation import rotation_matrix, rotation_vector
from analysis.photometric.follow.orientation_search import Found, search_orientation, turns
from tests.unit.analysis.photometric.drawn import (
    sight_of,
    sphere_image,
    spread_markers,
    stance_at,
    with_noise,
)

RADIUS, PLACE = 20.0, (32.18, 32.24)

ALIKE = np.array(
    [
        [0.84, 0.37, 0.40],
        [-0.42, 0.45, 0.79],
        [-0.08, -0.93, 0.37],
        [0.67, -0.48, -0.57],
        [-0.18, 0.68, -0.71],
        [0.97, 0.06, -0.24],
        [0.15, 0.96, -0.23],
        [0.45, 0.83, 0.32],
        [-0.05, -0.70, -0.71],
        [-0.97, 0.22, -0.03],
        [-0.56, -0.52, -0.64],
        [-0.67, 0.18, -0.73],
        [0.50, -0.83, 0.24],
        [0.14, 0.29, -0.95],
        [0.33, 0.36, 0.87],
        [-0.46, -0.56, 0.69],
    ]
)
"""Sixteen markers of which five lie, turned by 171 degrees, nearly where four others are."""
ALIKE_TURN = np.array([-0.092, 0.048, 0.015])


def found(markers: NDArray[np.float64], turn: NDArray[np.float64], *, noise: float = 2.0) -> Found:
    markers = markers / np.linalg.norm(markers, axis=1)[:, None]
    drawn = sphere_image(place=PLACE, radius=RADIUS, markers=markers @ rotation_matrix(turn).T)
    sight = sight_of(with_noise(drawn, noise, 1), markers, radius=RADIUS, noise=noise)
    return search_orientation(sight, stance_at(PLACE[0] + 0.2, PLACE[1] + 0.2, RADIUS), turns())


def off_deg(one: Found, turn: NDArray[np.float64]) -> float:
    between = one.stance.rotation @ rotation_matrix(turn).T
    return float(np.degrees(np.linalg.norm(rotation_vector(between))))


def test_markers_that_nearly_fit_turned_around_are_not_mixed_up() -> None:
    assert off_deg(found(ALIKE, ALIKE_TURN), ALIKE_TURN) < 1.0


@pytest.mark.parametrize("seed", range(12))
def test_eight_markers_tell_how_a_sphere_stands_or_that_they_do_not(seed: int) -> None:
    turn = np.random.default_rng(seed).normal(size=3)
    one = found(spread_markers(8, seed), turn)
    assert off_deg(one, turn) < 2.0 or not one.certain


def test_two_markers_that_can_be_exchanged_leave_the_turn_uncertain() -> None:
    pair = np.array([[0.0, 0.45, 0.89], [0.0, -0.45, 0.89]])
    assert not found(pair, np.zeros(3)).certain


def test_a_third_marker_decides_which_of_two_is_which() -> None:
    three = np.array([[0.0, 0.45, 0.89], [0.0, -0.45, 0.89], [0.7, 0.2, 0.68]])
    one = found(three, np.array([0.1, 0.2, -0.1]))
    assert one.certain
    assert off_deg(one, np.array([0.1, 0.2, -0.1])) < 2.0
