"""What a ball bounces off: bounces of a floor belong together, each off a wall is by itself."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from analysis.balls.seen.arcs import Arc, Chain
from analysis.balls.surfaces import parts

FALL = np.array([1000.0, 0.0])
LASTS_S, STEP_S = 0.2, 0.01
FLOOR, WALL = (-1.0, 1.0), (1.0, -1.0)
"""What bounces make of the speeds down and across."""


def chain(bounces: Sequence[tuple[float, float]], across: float = 300.0) -> Chain:
    """Return flights that meet in bounces, each of which turns one of the two speeds round."""
    place, speed, begun = np.array([0.0, 0.0]), np.array([100.0, across]), 0.0
    arcs, times, places = [], [], []
    for number in range(len(bounces) + 1):
        gone = np.arange(0.0, LASTS_S, STEP_S)
        own = place + speed * gone[:, None] + 0.5 * FALL * gone[:, None] ** 2
        frames = np.arange(len(gone)) + number * len(gone)
        arcs.append(Arc(frames, begun + gone, own, float(len(gone))))
        place = place + speed * LASTS_S + 0.5 * FALL * LASTS_S**2
        speed, begun = speed + FALL * LASTS_S, begun + LASTS_S
        if number < len(bounces):
            speed = speed * np.array(bounces[number])
            times.append(begun)
            places.append(place)
    return Chain(tuple(arcs), np.array(times), np.array(places).reshape(-1, 2))


def test_bounces_of_a_floor_are_one_part_as_they_were() -> None:
    whole = chain([FLOOR, FLOOR])
    (part,) = parts(whole, FALL)
    assert part.chain is whole
    assert part.lean == 0.0


def test_a_flight_without_a_bounce_is_one_part() -> None:
    (part,) = parts(chain([]), FALL)
    assert len(part.chain.arcs) == 1


def test_a_floor_that_turns_a_ball_round_by_its_spin_is_no_wall() -> None:
    (part,) = parts(chain([(-0.7, -0.8)], across=4000.0), FALL)
    assert part.lean == 0.0


@pytest.mark.parametrize(("across", "lean"), [(300.0, -math.pi / 2), (-300.0, math.pi / 2)])
def test_a_wall_between_bounces_of_a_floor_parts_them(across: float, lean: float) -> None:
    found = parts(chain([FLOOR, FLOOR, WALL, FLOOR], across), FALL)
    assert [len(part.chain.times_s) for part in found] == [2, 1, 1]
    assert [part.lean for part in found] == pytest.approx([0.0, 0.0, lean])
    # The flights before and after the wall belong to both sides of it.
    assert found[2].chain.arcs == (found[0].chain.arcs[-1], found[1].chain.arcs[0])
