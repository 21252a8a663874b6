"""Which fields of a playback repeat the one before, and how far a new one has moved on."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats

Pictures = NDArray[np.uint8]

QUIET_SHARE = 0.7
"""Of the pixels, those that differ least: what moves covers less than the rest."""
QUIET_POWER = 0.3096
"""Mean square of that share of normal numbers of standard deviation 1 that lie next to zero."""
LEAST_RATIO = 1.3
"""Noise of two recorded pictures against that of one digitised twice, to tell them apart."""
FROZEN_LEVELS = 0.05
"""Pictures that differ by less all over are one picture."""
LONGEST_ADVANCE = 4
"""Pictures by which a field may be ahead of the one before and be told by what moved."""
NEIGHBOURS = 4
"""New pictures on each side from which the usual motion is taken."""
LEAST_MOTION = 1.2
"""Of the noise's power, what a difference must have to show motion."""
_LEAST_SPREAD = 0.1
"""Least standard deviation of the logarithm of a motion from the usual one."""
_FARTHEST = 6.0
"""Standard deviations beyond which one motion is as unlikely as another."""
_LEAST_STEP = 0.15
"""What one picture more must add to that logarithm."""


@dataclass(frozen=True, slots=True, eq=False)
class Changes:
    """What the fields of a playback themselves say, K fields.

    Attributes
    ----------
    starts
        For each field, the first of those that show what it shows, shape (K,): itself when new.
    advance
        Log-likelihood that a field is 0, 1... pictures ahead of the one before by what moved,
        shape (K, LONGEST_ADVANCE + 1); zeros where nothing tells.
    told
        Whether repeats differ from new pictures, or all fields are new.
    """

    starts: NDArray[np.int64]
    advance: Floats
    told: bool


def changes(fields: Pictures) -> Changes:
    """Compare each field with the one before, shape (K, rows, columns).

    A picture that was digitised twice differs by the grabber's noise, two pictures by the
    recorder's too, and by what moved.
    """
    repeats, told = _repeats(fields)
    starts = np.arange(len(fields))
    for place in range(1, len(fields)):
        if repeats[place]:
            starts[place] = starts[place - 1]
    return Changes(starts, _advances(fields, starts), told)


def _repeats(fields: Pictures) -> tuple[NDArray[np.bool_], bool]:
    """Return which fields repeat the one before, and whether that can be told."""
    none = np.zeros(len(fields), dtype=np.bool_)
    if len(fields) < 2:
        return none, True
    pairs = [_differences(*pair) for pair in pairwise(fields)]
    quiet, whole = np.array(pairs).T
    # Codecs hold a background still: then what moves has to tell.
    measure = quiet if np.median(quiet) > FROZEN_LEVELS else whole
    levels = np.log(np.maximum(measure, FROZEN_LEVELS / 4))
    ranked = np.sort(levels)
    gaps = np.diff(ranked)
    if len(gaps) == 0 or gaps.max() < np.log(LEAST_RATIO):
        frozen = bool(ranked[-1] < np.log(FROZEN_LEVELS))
        none[1:] = frozen
        return none, frozen or bool(ranked[0] > np.log(FROZEN_LEVELS))
    widest = int(gaps.argmax())
    none[1:] = levels < (ranked[widest] + ranked[widest + 1]) / 2
    return none, True


def _differences(before: Pictures, after: Pictures) -> tuple[float, float]:
    """Return the root mean square difference of the quietest pixels, and of all."""
    squares = np.square(after.ravel().astype(np.float32) - before.ravel())
    kept = int(QUIET_SHARE * squares.size)
    quiet = np.partition(squares, kept)[:kept]
    return float(np.sqrt(quiet.mean())), float(np.sqrt(squares.mean()))


def _advances(fields: Pictures, starts: NDArray[np.int64]) -> Floats:
    """Return the log-likelihood of each advance of a new picture by what moved.

    The yardstick is the film itself: how much more two pictures differ that are 2, 3... new
    pictures apart, near the place and not across it.
    """
    known = np.zeros((len(fields), LONGEST_ADVANCE + 1))
    new = np.flatnonzero(starts == np.arange(len(fields)))
    motion = _motion(fields[new])
    usual = {
        place: found for place in range(1, len(new)) if (found := _usual(motion, place)) is not None
    }
    if not usual:
        return known
    off = {place: motion[0, place - 1] - found for place, found in usual.items()}
    # Most new pictures are the next one: how far those scatter is how far any may.
    scatter = 1.5 * np.median([abs(found[0]) for found in off.values()])
    spread = max(_LEAST_SPREAD, float(scatter))
    for place, found in off.items():
        farthest = np.clip(found / spread, -_FARTHEST, _FARTHEST)
        known[new[place], 1:] = -0.5 * np.square(farthest)
        known[new[place], 0] = known[new[place], 1:].min()
    return known


def _motion(pictures: Pictures) -> Floats:
    """Return the log of what moved from each picture to the one 1, 2... later.

    NaN where noise hides it, and beyond the end. Noise is taken from the quietest pixels.
    """
    count = len(pictures)
    motion = np.full((LONGEST_ADVANCE, count), np.nan)
    for lag in range(1, LONGEST_ADVANCE + 1):
        for place in range(count - lag):
            quiet, whole = _differences(pictures[place], pictures[place + lag])
            noise = quiet**2 / QUIET_POWER
            if whole**2 > LEAST_MOTION * noise:
                motion[lag - 1, place] = np.log(whole**2 - noise)
    return motion


def _usual(motion: Floats, place: int) -> Floats | None:
    """Return the usual motion over 1, 2... pictures about a place; None where none is seen."""
    medians = []
    for lag in range(1, LONGEST_ADVANCE + 1):
        before = motion[lag - 1, max(0, place - lag - NEIGHBOURS) : max(0, place - lag)]
        after = motion[lag - 1, place : place + NEIGHBOURS]
        seen = np.concatenate([before, after])
        seen = seen[np.isfinite(seen)]
        if len(seen) < 2:
            return None
        medians.append(float(np.median(seen)))
    usual = np.array(medians)
    grows = bool((np.diff(usual) > _LEAST_STEP / 2).all()) and usual[1] - usual[0] > _LEAST_STEP
    return usual if grows and np.isfinite(motion[0, place - 1]) else None
