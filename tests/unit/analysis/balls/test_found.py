"""Which of several balls that a film may show is the one that is measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.discs.disc import Disc
from analysis.balls.found import Search, best_of
from analysis.balls.seen.arcs import Arc, Chain
from analysis.balls.seen.looks import Looks

RATE, FALL, HOP = 200.0, np.array([20_000.0, 0.0]), 40
"""Frames a second, px/s^2 and frames from bounce to bounce."""


def seen(radius: float, discs: int, hops: int, column: float = 100.0) -> Search:
    """A ball that was found as so many sure discs and flies from bounce to bounce."""
    arcs = []
    for hop in range(hops):
        gone = (np.arange(HOP) - 0.5 * HOP) / RATE
        frames = np.arange(HOP) + hop * HOP
        places = np.stack([300.0 + 0.5 * FALL[0] * gone**2, np.full(HOP, column)], axis=1)
        arcs.append(Arc(frames, frames / RATE, places, float(HOP)))
    bounces: Floats = np.arange(1.0, hops) * HOP / RATE
    chain = Chain(tuple(arcs), bounces, np.tile([500.0, column], (hops - 1, 1)))
    told = tuple((k, Disc(300.0, column, radius, 0.1, 0.1, 0.1, 1.0, -30.0)) for k in range(discs))
    looks = Looks(radius, 0.3, np.ones((6, 1)), np.ones((1, 1)), np.ones(1), told)
    times = np.arange(HOP * hops) / RATE
    nothing = np.zeros((0, 3))
    return Search(looks, chain, FALL, (), nothing, (), times * 0 + 1, None, True, times, ())


def test_a_ball_with_its_shadow_that_one_frame_shows_is_no_larger_ball() -> None:
    ball, with_shadow = seen(46.0, discs=12, hops=2), seen(52.0, discs=1, hops=3)
    assert best_of([ball, with_shadow]) is ball


def test_a_small_ball_that_flies_longer_than_a_large_thing_elsewhere_is_the_ball() -> None:
    hand, ball = seen(46.0, discs=12, hops=2), seen(12.0, discs=1, hops=3, column=300.0)
    assert best_of([hand, ball]) is ball


def test_another_size_of_the_same_ball_that_is_as_sure_and_flies_longer_is_the_ball() -> None:
    one, other = seen(46.0, discs=12, hops=2), seen(50.0, discs=8, hops=3)
    assert best_of([one, other]) is other


def test_of_two_sizes_of_a_ball_that_are_as_sure_the_one_that_flies_longer_counts() -> None:
    narrow, whole = seen(8.3, discs=1, hops=5), seen(10.4, discs=1, hops=6)
    assert best_of([narrow, whole]) is whole
    # A larger disc that is far less sure must fly much longer.
    sure = seen(8.3, discs=3, hops=5)
    assert best_of([sure, whole]) is sure


def test_a_ball_of_the_stated_size_counts_before_another_unless_that_flies_twice_as_long() -> None:
    other = seen(20.0, discs=12, hops=5)
    stated = replace(seen(30.0, discs=6, hops=4, column=300.0), contradicts=False)
    assert best_of([other, stated]) is stated
    # What bends so in a few frames only may be a shadow or a reflection.
    briefly = replace(seen(30.0, discs=6, hops=2, column=300.0), contradicts=False)
    assert best_of([other, briefly]) is other
