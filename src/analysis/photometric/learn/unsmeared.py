"""Frames as a shorter exposure would have shown them, for learning.

What a sphere looks like is learned from frames that are rendered as of one instant. From those of
a long exposure the difference is taken that the motion makes in the rendering of what is known so
far: the mean over the instants less the middle one. It is wrong by as much as what is known is, and
less with each round.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.photometric.follow.film import Film
from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.render.accumulation import lay_outer_instants, reach_of, span_along
from analysis.photometric.render.bands import (
    BAND,
    LANES,
    RESIDUAL,
    ROOT,
    derive,
    ground_of,
    lay_piece,
    look_up,
)
from analysis.photometric.render.covers import cover_canvases, paint_of
from analysis.photometric.render.sight import Reel, Sight, Stance, sight_at
from analysis.photometric.render.smear import MIDDLE


@part
def add_difference(sight: Sight, stance: Stance, view: int, change: Floats) -> None:
    """Add what the motion takes from the pixels of a view, grey levels, to those of a frame."""
    canvases, corner, places = cover_canvases(sight, stance, view)
    if places.shape[0] == 1:
        return
    rows, place = sight.optics.rows[view], (places[0, 0], places[0, 1], places[0, 2])
    disc, surface = sight.look.discs[view], sight.look.surfaces[view]
    reach2, paint = reach_of(disc, places), paint_of(sight, stance, view, place[2])
    bands, ground = np.empty((places.shape[0], LANES * BAND)), ground_of(sight, view)
    none: int = 0 * rows[0]
    size = (canvases.shape[1], canvases.shape[3])
    for i in range(max(rows[0] - corner[0], 0), min(size[0], rows[1] - corner[0])):
        y = corner[0] + i
        start, end = span_along(y, place, reach2, (corner[1], size[1]))
        while start < end:
            width = min(end - start, BAND)
            x, covers = corner[1] + start, canvases[0, i, :, start : start + width]
            lay_piece(ground, covers, (y, x, place), (bands[0], none, width))
            lay_outer_instants(ground, (canvases, places), (y, x, corner), (bands, none, width))
            for n in range(places.shape[0]):
                look_up(disc, surface, bands[n], width)
                derive(paint, bands[n], width)
            for k in range(np.uint64(width)):
                middle, outer = bands[0, RESIDUAL + k], bands[1, RESIDUAL + k]
                mean = 0.5 * (outer + bands[2, RESIDUAL + k])
                if bands[0, ROOT + k] > 0.0:
                    change[y, x + k] += (1.0 - MIDDLE) * (mean - middle)
            start += width


@compiled
def add_differences(reel: Reel, frames: NDArray[np.intp], changes: Floats) -> None:
    """Add what the motion takes from the pixels of some frames of a reel, grey levels."""
    for k in frames:
        sight, stance = sight_at(reel, k)
        for view in range(reel.optics.scales.shape[0]):
            add_difference(sight, stance, view, changes[k])


def unsmeared(film: Film, known: Appearance) -> Film:
    """Return a film as shorter exposures would have shown it; the same one without motion."""
    if not film.motion.any():
        return film
    changes = np.zeros(film.frames.shape)
    for i in (0, 1):
        add_differences(film.reel(known, i), np.flatnonzero(film.placed[i]), changes)
    frames = np.clip(film.frames + changes, 0.0, 255.0).astype(np.float32)
    return replace(film, frames=frames, motion=np.zeros_like(film.motion))
