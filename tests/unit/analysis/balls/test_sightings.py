"""Where something of a ball's looks differs from what stands still, in drawn pictures."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.balls.seen.looks import Looks, Sight

RADIUS, SHAPE = 14.0, (300, 400)
BALL, STILL = 180.0, 60.0
LOOKS = Looks(RADIUS, 0.1, np.array([1 / (BALL - STILL)]), np.array([1.0]), ())


def drawn(*places: tuple[float, float]) -> NDArray[np.uint8]:
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]]
    shown = np.full(SHAPE, STILL)
    for row, column in places:
        inside = np.clip(RADIUS - np.hypot(rows - row, columns - column) + 0.5, 0.0, 1.0)
        shown += inside * (BALL - STILL)
    return np.asarray(np.rint(shown)[..., None], np.uint8)


@pytest.mark.parametrize(
    "places",
    [
        [(150.0, 200.0)],
        [(14.0, 15.0), (285.0, 384.0)],
        [(40.0, 300.0), (250.0, 30.0), (150.0, 200.0)],
        [(299.0, 120.0)],
    ],
    ids=["in the middle", "in two corners", "three", "half out of the picture"],
)
def test_balls_are_seen_wherever_they_are(places: list[tuple[float, float]]) -> None:
    found = Sight(LOOKS, drawn()).find(drawn(*places)).places
    assert len(found) == len(places)
    for row, column in places:
        nearest = np.hypot(found[:, 0] - row, found[:, 1] - column).min()
        assert nearest < 0.3 * RADIUS


def test_nothing_is_seen_where_nothing_has_changed() -> None:
    assert len(Sight(LOOKS, drawn()).find(drawn()).places) == 0
