"""Pictures that a film leaves out in the rhythm of a lower rate: each sixth from 30 to 25 a second.

A program that brings a film to fewer frames a second gives each of them the picture of its time and
leaves the others out. The times of the file are even; those of the pictures are whole steps of the
camera, and a ball moves by one step too many wherever one was left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.seen.repeats import evenly_timed
from analysis.errors import ShotRefusedError

Flags = NDArray[np.bool_]

STEPS = 4
"""Steps of the pieces of a flight that are looked at, each against all counts of camera steps."""
LEAST_STEP_PX = 2.0
"""Path of a ball in a step of the camera: slower ones tell no times."""
SURE_PX, SURE_STEPS = 0.3, 0.03
"""Distance from a parabola with the right times, px and in steps of the camera: errors of places,
and what drag and perspective bend."""
ON = 0.08
"""Of a step: a piece that is farther from parabolas with all times holds a bounce."""
MOST_RATIO = 3
"""Pictures of the camera for each frame of the film."""
RATIOS, PHASES, SLIP = 60, 24, 1.0
"""Ratios between two whole ones that are tried, phases of each, and what a phase that moves by one
of these costs: rhythms drift, as of 29.97 pictures a second, and slip."""
LEAST_GAIN, LEAST_SEEN, SEEN, KEPT = 20.0, 4, 3.0, 0.8
"""What a rhythm explains, as a logarithm of odds; places where pictures are left out that are to be
seen, the odds of one that is, and the share of those of a rhythm that are seen so."""


class ThinnedError(ShotRefusedError):
    """A film that leaves pictures of the camera out in a rhythm.

    Parameters
    ----------
    pictures
        The number of each frame's picture among all that the camera took, shape (frames,).
    """

    def __init__(self, pictures: NDArray[np.intp]) -> None:
        super().__init__(
            "frames",
            f"the film shows {len(pictures)} of {int(pictures[-1]) + 1} pictures of the camera and "
            "leaves others out in a rhythm: it was brought to a lower rate; state the film that "
            "the camera wrote",
        )
        self.pictures = pictures

    @property
    def ratio(self) -> float:
        """Return pictures of the camera for each frame."""
        return float(np.polyfit(np.arange(len(self.pictures)), self.pictures, 1)[0])

    def times(self, times_s: Floats) -> Floats:
        """Return the times of the pictures, s, of frames whose even times are stated."""
        step_s = float(np.median(np.diff(times_s))) / self.ratio
        return np.asarray(times_s[0] + step_s * self.pictures)

    def note(self, times_s: Floats) -> str:
        """Say what a person should know of a film that is measured with these times."""
        steps = np.diff(self.pictures)
        first = int(np.argmax(steps > steps.min())) + 1
        rate = self.ratio / float(np.median(np.diff(times_s)))
        return (
            "the film was brought to a lower rate: it leaves pictures of the camera out in a "
            f"rhythm, one just before frame {first}, and shows {len(self.pictures)} of "
            f"{int(self.pictures[-1]) + 1}; its frames are measured at the times of the camera's "
            f"pictures, {rate:.4g} a second (--fps states the rate of all frames of the file)"
        )


def refuse_thinned(places: Sequence[Floats], times_s: Floats) -> None:
    """Raise `ThinnedError` where a ball's steps say that pictures are left out in a rhythm.

    Parameters
    ----------
    places
        Of each frame row, column and response of what looks like the ball, the surest first.
    times_s
        Of the frames, s.
    """
    if len(times_s) <= STEPS + 1 or not evenly_timed(times_s):
        return
    middle = np.array([p[0, :2] if len(p) else (np.nan, np.nan) for p in places]).reshape(-1, 2)
    for fewest in range(1, MOST_RATIO):
        pictures = _pictures(middle, fewest)
        if pictures is not None:
            raise ThinnedError(pictures)


def _pictures(middle: Floats, fewest: int) -> NDArray[np.intp] | None:
    """Return the picture that each frame shows, in a rhythm of `fewest` or one more each step.

    None where a ball's steps do not tell of one.

    Parameters
    ----------
    middle
        Row and column of the ball in each frame, px, shape (N, 2); nan where it is not seen.
    """
    firsts, gains = _pieces(middle, fewest)
    if gains.max(axis=1, initial=0.0).sum() < LEAST_GAIN:
        return None
    most, longer = _followed(len(middle) - 1, firsts, gains)
    if most < LEAST_GAIN or not _is_seen(longer, firsts, gains):
        return None
    return np.concatenate([[0], np.cumsum(fewest + longer)])


def _followed(steps: int, firsts: NDArray[np.intp], gains: Floats) -> tuple[float, Flags]:
    """Return what the best rhythm explains, and which of a film's steps are longer by it.

    A rhythm is a share of longer steps, and a phase that may move by one of PHASES from step to
    step, at a cost: the likeliest course of phases is followed (Viterbi, 1967).
    """
    shares, start = np.arange(1, RATIOS)[:, None] / RATIOS, np.arange(PHASES) / PHASES
    whole = (np.floor(n * shares + start) for n in range(steps + 1))
    longer = np.array([after > before for before, after in pairwise(whole)])
    told = dict(zip(firsts.tolist(), gains, strict=True))
    total, came = np.zeros((RATIOS - 1, PHASES)), np.zeros(longer.shape, np.int8)
    for n in range(steps):
        ways = np.stack([total, np.roll(total, 1, 1) - SLIP, np.roll(total, -1, 1) - SLIP])
        came[n] = (np.arange(PHASES) - np.array([0, 1, -1])[ways.argmax(axis=0)]) % PHASES
        total = ways.max(axis=0)
        if n in told:
            total += told[n][_pattern(longer[n : n + STEPS])]
    share, phase = np.unravel_index(int(total.argmax()), total.shape)
    found = np.zeros(steps, dtype=np.bool_)
    for n in range(steps - 1, -1, -1):
        found[n] = longer[n, share, phase]
        phase = came[n, share, phase]
    return float(total.max()), found


def _pattern(longer: Flags) -> NDArray[np.intp]:
    """Return the number of a pattern of longer steps along the first axis."""
    powers = 2 ** np.arange(STEPS - 1, -1, -1)
    return np.asarray(np.tensordot(powers, longer.astype(np.intp), axes=1))


def _is_seen(longer: Flags, firsts: NDArray[np.intp], gains: Floats) -> bool:
    """Return whether a ball's steps show nearly all longer ones of a rhythm."""
    own = gains[np.arange(len(firsts)), _pattern(longer[firsts + np.arange(STEPS)[:, None]])]
    told = np.array(
        [
            own[(firsts <= step) & (step < firsts + STEPS)].sum()
            for step in np.flatnonzero(longer).tolist()
        ]
    )
    seen, against = int((told > SEEN).sum()), int((told < -SEEN).sum())
    return seen >= LEAST_SEEN and seen >= KEPT * (seen + against)


def _pieces(middle: Floats, fewest: int) -> tuple[NDArray[np.intp], Floats]:
    """Return first frames of pieces of the ball's way, and how much better times explain each.

    Shape (pieces, patterns): the logarithm of odds against even times, for each pattern of steps
    that are `fewest` or one more of the camera's, the first step counting most.
    """
    counts = np.array(list(product((fewest, fewest + 1), repeat=STEPS)), dtype=np.float64)
    firsts = np.arange(len(middle) - STEPS)
    whole = np.isfinite(middle).all(axis=1)
    firsts = firsts[np.lib.stride_tricks.sliding_window_view(whole, STEPS + 1).all(axis=1)]
    places = middle[firsts[:, None] + np.arange(STEPS + 1)]
    away = np.empty((2, len(firsts), len(counts)))
    for n, each in enumerate(counts):
        times = np.concatenate([[0.0], np.cumsum(each)])
        away[0, :, n] = _off(np.vander(times, 3), places[..., 0])
        away[1, :, n] = _off(np.vander(times, 2), places[..., 1])
    moves = np.abs(np.diff(places, axis=1)).sum(axis=1) / counts.mean() / STEPS
    # A bounce bends the rows alone.
    whole_way = _gains(np.hypot(*away), np.hypot(*moves.T))
    across = _gains(away[1], moves[:, 1])
    return firsts, np.where(whole_way.any(axis=1, keepdims=True), whole_way, across)


def _gains(away: Floats, step_px: Floats) -> Floats:
    """Return logarithms of odds against even times; 0 of pieces that bounce or hardly move."""
    step = step_px[:, None]
    odds = np.log1p((away / (SURE_PX + SURE_STEPS * step)) ** 2)
    flies = (np.minimum(away, away[:, :1]) < ON * step) & (step > LEAST_STEP_PX)
    return np.where(flies, odds[:, :1] - odds, 0.0)


def _off(design: Floats, values: Floats) -> Floats:
    """Return how far least squares leave values, shape (pieces, frames); root of mean squares."""
    q, _ = np.linalg.qr(design)
    return np.asarray(np.sqrt(((values - values @ q @ q.T) ** 2).mean(axis=1)))
