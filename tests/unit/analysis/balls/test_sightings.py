"""Where something of a ball's looks differs from what stands still, in drawn pictures."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.balls.seen.looks import Looks
from analysis.balls.seen.sighting import Sight

RADIUS, SHAPE = 14.0, (300, 400)
BALL, STILL = 180.0, 60.0


def looks(values: float, downward: float = 0.0) -> Looks:
    """A grey ball, brighter by so much from its centre to its lower rim."""
    shading = np.zeros((6, 1))
    shading[:2, 0] = values, downward
    return Looks(RADIUS, 0.1, shading, np.array([[4.0]]), np.array([1.0]), ())


LOOKS = looks(BALL)


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


WALL, TABLE, EDGE = 200.0, 60.0, 150
"""A wall behind a table whose far edge is seen at a row."""


def before_two(
    place: tuple[float, float], ball: float, downward: float, shadow: tuple[float, float]
) -> NDArray[np.uint8]:
    """A ball before a wall and a table, and a shadow of its size on either."""
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]]
    shown = np.where(rows < EDGE, WALL, TABLE)
    shade = np.hypot((rows - shadow[0]) / 0.6, columns - shadow[1]) < RADIUS
    shown = np.where(shade, 0.7 * shown, shown)
    down = (rows - place[0]) / RADIUS
    inside = np.clip(RADIUS - np.hypot(rows - place[0], columns - place[1]) + 0.5, 0.0, 1.0)
    shown += inside * (ball + downward * down - shown)
    return np.asarray(np.rint(shown)[..., None], np.uint8)


@pytest.mark.parametrize("row", [60.0, 130.0, 150.0, 170.0, 240.0])
@pytest.mark.parametrize(
    ("ball", "downward"),
    [(140.0, 0.0), (WALL, -45.0)],
    ids=["darker than the wall", "as bright as the wall"],
)
def test_a_ball_is_followed_before_a_wall_and_a_table_and_its_shadow_is_not(
    row: float, ball: float, downward: float
) -> None:
    away = (-100.0, -100.0)
    sight = Sight(looks(ball, downward), before_two(away, ball, downward, away))
    shown = before_two((row, 200.0), ball, downward, (270.0, 240.0))
    places = sight.find(shown).places
    assert np.hypot(places[0, 0] - row, places[0, 1] - 200.0) < 0.2 * RADIUS
    assert len(places) == 1


@pytest.mark.parametrize("place", [(60.3, 200.6), (190.0, 31.0), (238.4, 366.2)])
def test_a_ball_that_is_hardly_seen_is_not_left_out_beforehand(
    place: tuple[float, float],
) -> None:
    # 45 % of a ball's light: the least-squares share of a whole ball that is half transparent.
    away, share = (-100.0, -100.0), 0.45
    ground, ball = (
        before_two(where, WALL, -45.0, away).astype(np.float64) for where in (away, place)
    )
    shown = np.asarray(np.rint(ground + share * (ball - ground)), np.uint8)
    sight = Sight(looks(WALL, -45.0), np.asarray(ground, np.uint8))
    best = sight.find(shown).places[0]
    assert np.hypot(*(best[:2] - place)) < 0.3 * RADIUS
    assert best[2] == pytest.approx(share, abs=0.12)
