"""Chains of many pieces of flight: each two are compared once, whatever chains they end up in."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.seen import arcs as own
from analysis.balls.seen.arcs import Arc, chains

RATE, FALL, RADIUS = 200.0, np.array([2800.0, 0.0]), 14.0
HOP_FRAMES = 40


def hops(column: float, first: int, count: int) -> list[Arc]:
    """A ball that bounces in one column: parabolas over a plate at row 300, one after another."""
    gone = np.arange(1, HOP_FRAMES) / RATE
    up = 0.5 * FALL[0] * HOP_FRAMES / RATE
    rows = 300.0 - up * gone + 0.5 * FALL[0] * gone**2
    places = np.stack([rows, np.full(len(rows), column)], axis=1)
    found = []
    for k in range(count):
        frames = np.arange(1, HOP_FRAMES) + first + k * HOP_FRAMES
        found.append(Arc(frames, frames / RATE, places, float(len(rows) + column / 1e3)))
    return found


def test_each_ball_has_its_chain_the_strongest_first() -> None:
    found = chains([*hops(100.0, 0, 3), *hops(300.0, 5, 4)], RADIUS, FALL)
    assert [len(chain.arcs) for chain in found] == [4, 3]
    at = [300.0, 300.0, 300.0], [5.0 + HOP_FRAMES * k for k in (1, 2, 3)]
    assert found[0].places[:, 0] == pytest.approx(at[0], abs=1e-6)
    assert found[0].times_s * RATE == pytest.approx(at[1], abs=1e-6)


def test_pieces_of_many_balls_are_compared_once_and_with_neighbours_in_time_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    courses = 0
    course_of = Arc.course_of

    def counted(arc: Arc, part: slice, fall: Floats) -> tuple[float, Floats, Floats]:
        nonlocal courses
        courses += 1
        return course_of(arc, part, fall)

    monkeypatch.setattr(own.Arc, "course_of", counted)
    balls, each = 8, 5
    many = [arc for k in range(balls) for arc in hops(100.0 * k, 3 * k, each)]
    many.sort(key=lambda arc: float(arc.times_s[0]))
    assert len(chains(many, RADIUS, FALL)) == balls
    # Pairs in which one begins within two hops after the other, and two courses of each.
    assert courses <= 2 * len(many) * 2 * balls


@pytest.mark.parametrize(("seen_before_it", "bounces"), [(0, 1), (3, 0)])
def test_a_ball_that_is_seen_on_its_way_up_before_it_came_down_has_not_bounced(
    seen_before_it: int, bounces: int
) -> None:
    """To a telephone two balls pass each other as one would bounce."""
    rate, bounce = 30.0, 12.5
    came, left = np.arange(10), np.arange(13 - seen_before_it, 26)

    def flight(frames: NDArray[np.intp], speed: float) -> Arc:
        gone = (frames - bounce) / rate
        rows = 900.0 + speed * gone + 0.5 * FALL[0] * gone**2
        return Arc(frames, frames / rate, np.stack([rows, 0.0 * rows], axis=1), float(len(rows)))

    found = chains([flight(came, 1200.0), flight(left, -900.0)], RADIUS, FALL)
    assert sum(len(chain.times_s) for chain in found) == bounces
