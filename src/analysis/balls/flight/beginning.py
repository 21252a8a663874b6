"""Where a fit of flights begins, in the numbers of `path`, by a first guess of the bounces."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.flights import LEAST_PLACES, Observed, Start
from analysis.balls.flight.known import LOOK_SIGMA

LEAST_SPEED = 1e-3
"""px/s, towards a level plate and away from it."""
FOCAL_SIGMAS = np.linspace(-3.0, 3.0, 61)
"""Focal lengths that are tried, in errors of what is known of it."""


def off_contacts(observed: Observed, start: Start, fall: float, longest_s: float) -> Start:
    """Return the same bounces with speeds by places that are off any contact that may be.

    Speeds that a search finds are those of frames beside a bounce, in which a fast camera shows
    the ball in contact.

    Parameters
    ----------
    fall
        px/s^2.
    longest_s
        How long a contact may last.
    """
    speeds = np.stack([start.before, start.after])
    ends = np.concatenate([[-np.inf], start.times_s, [np.inf]])
    times = observed.times_s
    for k, contact in enumerate(start.times_s):
        for side, (begin, end) in enumerate(((ends[k], contact), (contact, ends[k + 2]))):
            own = (times > begin + longest_s) & (times < end - longest_s)
            if own.sum() < LEAST_PLACES:
                continue
            since = times[own] - contact
            flown = observed.places[own] - 0.5 * np.outer(since**2, [fall, 0.0])
            design = np.stack([np.ones(len(since)), since], axis=1)
            speeds[side, k] = np.linalg.lstsq(design, flown, rcond=None)[0][1]
    return replace(start, before=speeds[0], after=speeds[1])


def first_numbers(start: Start, prior: Floats) -> Floats:
    """Return the fit's numbers by bounces, and for the rest what is known of them, shape (P,)."""
    values = np.where(np.isfinite(prior), prior, 0.0)
    if start.fall is not None:
        values[path.FALL] = math.log(start.fall)
    values[path.TIME] = start.times_s[0]
    values[path.TILT] = start.lean
    least = -np.inf if start.lean else LEAST_SPEED
    values[path.SPEED] = max(least, start.before[0, 0])
    values[path.PLACE] = start.places[0, 1] - prior[path.MIDDLE_COLUMN]
    values[path.ACROSS] = start.before[0, 1]
    values[path.PLATE] = float(np.median(start.places[:, 0]))
    for k, (down, across) in enumerate(start.after):
        own = path.COMMON + path.EACH * k
        values[own : own + 2] = max(least, -down), across
    return values


def receding(
    begin: Floats, start: Start, rate: float, aslant: tuple[float, float]
) -> Floats | None:
    """Return where a fit of several bounces may begin too, with a drift; None: there is but one.

    A fit that begins without drift does not find one that is far larger than believed: bounces of a
    ball that comes nearer sink in the picture of a camera that looks down, and the fit takes them
    for others.

    Parameters
    ----------
    begin
        Without drift, shape (P,).
    rate
        The drift, distances of the camera a second.
    aslant
        What is known of `path.ASLANT`: its logarithm and the standard error of that.
    """
    if len(start.times_s) < 2:
        return None
    values = begin.copy()
    since = start.times_s - start.times_s.mean()
    # What comes nearer also moves away from the principal point.
    sinks = float(since @ start.places[:, 0] / (since @ since))
    rise = -sinks / rate - (begin[path.PLATE] - begin[path.MIDDLE_ROW])
    # The likeliest focal length with which a camera's tilt, rise over focal length, does that.
    side, tried = 2.0 * begin[path.HALF], aslant[0] + aslant[1] * FOCAL_SIGMAS
    tilts = rise * np.exp(0.5 * tried) / side
    best = int(np.argmin((tilts / LOOK_SIGMA) ** 2 + FOCAL_SIGMAS**2))
    values[path.DEPTH], values[path.ASLANT] = rate, tried[best]
    values[path.PERSPECTIVE] = tilts[best] * math.exp(0.5 * tried[best]) / side
    return values
