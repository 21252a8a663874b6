"""Where the ball is in the pictures of a film that are shown first."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from analysis.balls.films.film import Picture
from analysis.balls.searching import rings
from analysis.balls.seen.looks import weighted_median

RADIUS = 14.0
PLACES = {0: (40.0, 30.0), 9: (60.5, 52.0), 18: (90.0, 75.25), 27: (60.0, 98.0), 36: (95.0, 121.5)}
NONE = 45


def picture(place: tuple[float, float] | None, rng: np.random.Generator) -> Picture:
    """Draw a disc at row and column over stripes that stand still, with noise."""
    rows, columns = np.mgrid[:140, :160]
    ground = 70.0 + 12.0 * np.sin(0.2 * rows) + 0.1 * columns
    if place is not None:
        away = np.hypot(rows - place[0], columns - place[1])
        ground += np.clip(RADIUS + 0.5 - away, 0.0, 1.0) * (190.0 - ground)
    soft = cv2.GaussianBlur(ground, (0, 0), 0.8) + rng.normal(0, 1.5, ground.shape)
    return soft.round().clip(0, 255).astype(np.uint8)[..., None]


def test_the_ball_is_ringed_in_each_picture_that_shows_it() -> None:
    rng = np.random.default_rng(3)
    pictures = {frame: picture(place, rng) for frame, place in PLACES.items()}
    found = rings(pictures | {NONE: picture(None, rng)})
    assert set(found) == set(PLACES)
    for frame, (row, column) in PLACES.items():
        ring = found[frame]
        assert abs(ring.row - row) < 0.3
        assert abs(ring.column - column) < 0.3
        assert abs(ring.radius - RADIUS) < 0.6


def test_where_nothing_moves_nothing_is_ringed() -> None:
    rng = np.random.default_rng(4)
    assert rings({frame: picture((40.0, 30.0), rng) for frame in range(8)}) == {}


def test_a_median_counts_values_by_their_weights() -> None:
    values = np.array([5.0, 1.0, 3.0])
    assert weighted_median(values, np.ones(3)) == 3.0
    assert weighted_median(values, np.array([1.0, 1e-6, 1e-6])) == pytest.approx(5.0, abs=1e-4)
    assert weighted_median(np.array([7.0]), np.array([0.1])) == 7.0
