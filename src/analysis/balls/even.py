"""Stretches of a film in which one rate holds, of a film whose times do not say that it varies."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from analysis.arrays import Floats
from analysis.balls.falling import arcs_of
from analysis.balls.flight.flights import LEAST_PLACES
from analysis.balls.flight.known import Ball
from analysis.balls.flight.lost import MOST_SCATTER_PX
from analysis.balls.measuring import MeasuredBall, coefficient
from analysis.balls.seen.arcs import Arc, Chain, Sightings, chains
from analysis.balls.seen.free_fall import STATED_SHARE, bend_of, flown

SURE_E = 0.02
"""Standard error of e up to which a bounce is measured."""
SIGMAS = 2.0


def in_doubt(measured: MeasuredBall) -> bool:
    """Return whether a film's flights do not fit its times, or it has no bounce."""
    flights = measured.flights
    if flights is None or measured.more_gaps or flights.doubt > 0.0:
        return True
    return float(np.std(flights.residuals[flights.used, 0])) > MOST_SCATTER_PX


def sure_bounces(measured: MeasuredBall) -> int:
    """Return of how many bounces e is measured."""
    each = [coefficient(measured, bounce)[1] for bounce in range(measured.bounces)]
    return sum(sigma < SURE_E for sigma in each)


def even_stretches(measured: MeasuredBall, times_s: Floats, ball: Ball) -> list[tuple[int, int]]:
    """Return first and last frames between which a ball falls and bounces as the rate says.

    The one with most bounces comes first.

    Parameters
    ----------
    times_s
        Of all frames as they were stated, s.
    """
    looks = measured.looks
    fall = np.array([ball.gravity * 2.0 * looks.radius_px / ball.diameter_m, 0.0])
    seen = _sightings(measured, times_s)
    alike = []
    for whole in arcs_of(seen, looks, fall):
        # An arc goes on for some frames where the rate changes in a flight.
        (arc,) = flown(Chain((whole,), np.zeros(0), np.zeros((0, 2))), looks.radius_px).arcs
        bend = bend_of([arc], looks, fall)
        if bend is not None and abs(bend[0] - 1.0) < STATED_SHARE + SIGMAS * bend[1]:
            alike.append(arc)
    runs = [run for one in chains(alike, looks.radius_px, fall) for run in _runs(one.arcs)]
    runs.sort(key=lambda run: (-len(run), run[0].frames[0] - run[-1].frames[-1]))
    return [(int(run[0].frames[0]), int(run[-1].frames[-1])) for run in runs if len(run) > 1]


def _runs(arcs: Sequence[Arc]) -> list[list[Arc]]:
    """Return arcs that follow one another; where frames lie between two, the rate has changed."""
    runs = [[arcs[0]]]
    for before, arc in pairwise(arcs):
        if arc.frames[0] - before.frames[-1] > LEAST_PLACES:
            runs.append([])
        runs[-1].append(arc)
    return runs


def _sightings(measured: MeasuredBall, times_s: Floats) -> Sightings:
    """Return where the ball is seen, in its flights and beside them."""
    search, head = measured.search, measured.head
    every: list[Chain] = [search.chain, *(other for other, _ in search.others)]
    places: list[Floats] = [np.zeros((0, 3)) for _ in range(head.frames)]
    for frame, row, column in search.unexplained.tolist():
        places[int(frame)] = np.array([[row, column, 1.0]])
    for chain in reversed(every):
        for arc in chain.arcs:
            for frame, (row, column) in zip(arc.frames.tolist(), arc.places, strict=True):
                places[frame] = np.array([[row, column, 1.0]])
    return Sightings(times_s, places, (head.height, head.width))
