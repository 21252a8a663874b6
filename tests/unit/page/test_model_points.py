"""Points of a cell are drawn wherever any lies, and none upon another."""

from __future__ import annotations

from random import Random

from rigctl.page.model.where import ACROSS, ALL_DRAWN, BY_POINT, UP, apart


def test_a_few_points_are_drawn_each() -> None:
    points = cloud(ALL_DRAWN)
    assert apart(points) is points


def test_of_many_points_those_upon_others_are_left_out_and_the_rest_keeps_its_numbers() -> None:
    points = cloud(3000)
    drawn = apart(points)
    numbers = drawn["shots"]
    assert len(numbers) < 2500
    assert [drawn[name] for name in BY_POINT] == [
        [points[name][number] for number in numbers] for name in BY_POINT
    ]
    assert drawn["trend"] == points["trend"]


def test_every_point_that_is_left_out_lies_upon_one_that_is_drawn() -> None:
    points = cloud(3000)
    drawn = apart(points)
    across = (max(points["x"]) - min(points["x"])) / ACROSS
    up = (max(points["residual"]) - min(points["residual"])) / UP
    seen = list(zip(drawn["x"], drawn["residual"], strict=True))
    for x, y in zip(points["x"], points["residual"], strict=True):
        assert any(abs(x - a) <= across and abs(y - b) <= up for a, b in seen)


def test_points_in_one_line_are_drawn() -> None:
    points = {**cloud(1000), "residual": [0.0] * 1000}
    assert 1 < len(apart(points)["x"]) <= ACROSS + 1


def cloud(count: int) -> dict[str, object]:
    """Return points of a cell, as dense in their middle as residuals are."""
    draw = Random(5)
    return {
        "shots": list(range(count)),
        "frames": [-1] * count,
        "x": [draw.gauss(0.0, 1.0) for _ in range(count)],
        "residual": [draw.gauss(0.0, 0.02) for _ in range(count)],
        "sigma": [0.02] * count,
        "trend": {"x": [0.0], "mean": [0.0], "sigma": [0.1]},
    }
