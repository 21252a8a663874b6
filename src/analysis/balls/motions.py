"""Where a ball is in each frame of a film and how fast it moves: as it is seen, or as it flies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight.flights import Flights
from analysis.balls.seen.arcs import Chain
from analysis.balls.seen.windows import Motion, Window

NEIGHBOURS = 5
"""Sightings before and after that tell a speed before any flight is fitted."""
SPEED_STEP_S = 1e-4
NEAREST, MOST_LARGER = 0.1, 0.2
"""Of a ball's distance, nearer than which no flight brings it, and of its radius, by which it is
seen larger at most: numbers of a first fit may run beyond."""


def windows_of(windows: Sequence[Window], motion: Motion) -> list[Window]:
    """Return the windows of the frames of a motion."""
    known = set(motion.frames.tolist())
    return [window for window in windows if window.frame in known]


def seen_motion(chain: Chain, fall: Floats) -> Motion:
    """Return places as seen, and speeds from the sightings about each."""
    frames, places, speeds = [], [], []
    for arc in chain.arcs:
        for k, frame in enumerate(arc.frames.tolist()):
            part = slice(max(0, k - NEIGHBOURS), k + NEIGHBOURS + 1)
            middle, _, speed = arc.course_of(part, fall)
            frames.append(frame)
            places.append(arc.places[k])
            speeds.append(speed + fall * (arc.times_s[k] - middle))
    order = np.argsort(frames, kind="stable")
    frames_, index = np.unique(np.array(frames)[order], return_index=True)
    return Motion(frames_, np.array(places)[order][index], np.array(speeds)[order][index])


def fitted_motion(flights: Flights) -> Motion:
    """Return places, speeds and sizes as the flights have them."""
    placed = flights.observed
    times = flights.observed.times_s + flights.row_delay(flights.observed.places)
    here, ahead, behind = (
        flights.at(times + step, flights.arcs) for step in (0.0, SPEED_STEP_S, -SPEED_STEP_S)
    )
    near = 1.0 / np.maximum(here[:, 2], NEAREST)
    larger = np.clip(near / np.median(near) - 1.0, -MOST_LARGER, MOST_LARGER)
    speeds = (ahead - behind)[:, :2] / (2 * SPEED_STEP_S)
    return Motion(placed.frames, here[:, :2], speeds, larger)
