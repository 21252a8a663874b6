"""Frames in which a track is no free flight any more: a test without a law of contact.

Each frame is predicted by a straight line, gravity taken out, through the last good ones. One that
lies off by more than its errors, or is far less certain than its track, is bad; where three in a
row are, the track is torn and ends.

Orientations are kept as far as one rate holds them together: a free sphere turns at one between
contacts. Where few markers are seen an orientation may be wrong by a marker's distance and more,
frame after frame, at a stated error of a degree.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.motion.rotation import rotation_matrix, rotation_vector
from analysis.motion.velocity import DOWN, slowed_by_drag

Track = tuple[Floats, Floats, Floats, Floats]
"""Time from the contact, s, shape (n,); centres with gravity taken out, their standard errors,
infinite where a coordinate was not measured, and how far the air may bend the track off a straight
line, m, shape (n, 3)."""
Labels = NDArray[np.int64]

WINDOW = 25
"""Good frames that predict the next."""
LEAST, FIRST = 4, 6
"""Frames next to the contact that begin, all of them good; if they are not, LEAST of FIRST."""
MOST_SIGMAS, MOST_OFF_M = 6.0, 20e-6
"""A frame may lie off by this many of its errors and this far more: what lasts in a track bends
it a little."""
LESS_CERTAIN = 6.0
"""Times the median error of the good frames."""
IN_A_ROW = 3
SOUND, OFF, UNCERTAIN, BEYOND = 0, 1, 2, 3


def label_side(
    tau: Floats, position: Floats, sigma: Floats, *, gravity: float, slows_per_m: float
) -> Labels:
    """Label the frames on one side of a contact, from it outward, as `torn` does.

    Parameters
    ----------
    tau
        Times from the contact, s, shape (n,).
    position, sigma
        Centres and standard errors, m, shape (n, 3); infinite where a coordinate was not measured.
    gravity
        m/s^2 along +X.
    slows_per_m
        Deceleration by the air over the square of the speed, at most.
    """
    known, sigma = np.isfinite(sigma), np.ascontiguousarray(sigma)
    straight = np.where(known, position, 0.0) - 0.5 * gravity * np.outer(tau**2, DOWN)
    steps, shown = np.diff(straight, axis=0) / np.diff(tau)[:, None], known[1:] & known[:-1]
    velocity = np.zeros(3)
    for axis in np.flatnonzero(shown.any(axis=0)):
        velocity[axis] = np.median(steps[shown[:, axis], axis])
    bent = slows_per_m * slowed_by_drag(tau, velocity, gravity * DOWN)
    return np.asarray(torn(tau, straight, sigma, bent))


@compiled
def torn(tau: Floats, straight: Floats, sigma: Floats, bent: Floats) -> Labels:
    """Label the frames on one side of a contact, from it outward.

    Parameters
    ----------
    tau, straight, sigma, bent
        Of a `Track`.

    Returns
    -------
    SOUND, OFF, UNCERTAIN or BEYOND the end of the track, shape (n,). All are SOUND where there are
    fewer than LEAST.
    """
    count, track = tau.size, (tau, straight, sigma, bent)
    labels = np.zeros(count, dtype=np.int64)
    if count < LEAST:
        return labels
    first = LEAST
    if not begin(track, labels, (0, first)):
        first = min(FIRST, count)
        labels[:first] = SOUND
        if not begin(track, labels, (0, first)):
            labels[:] = BEYOND
            return labels
    row = 0
    for k in range(count):
        if k >= first:
            labels[k] = label_frame(track, labels, (0, k), k)
        row = row + 1 if labels[k] != SOUND else 0
        if row == IN_A_ROW:
            labels[k - IN_A_ROW + 1 :] = BEYOND
            break
    return labels


@part
def begin(track: Track, labels: Labels, among: tuple[int, int]) -> bool:
    """Mark those of the first frames that do not lie on one line.

    Parameters
    ----------
    among
        Half-open range of the first frames.

    Returns
    -------
    Whether LEAST of them do.
    """
    left = among[1] - among[0]
    while left >= LEAST:
        worst, which = 1.0, -1
        for k in range(among[0], among[1]):
            if labels[k] == SOUND:
                labels[k] = OFF
                beside = beyond(track, labels, among, k)
                labels[k] = SOUND
                if beside > worst:
                    worst, which = beside, k
        if which < 0:
            return True
        labels[which] = OFF
        left -= 1
    return False


@part
def label_frame(track: Track, labels: Labels, among: tuple[int, int], k: int) -> int:
    """Return the label of a frame by the nearest SOUND ones in a half-open range on one side."""
    if beyond(track, labels, among, k) > 1.0:
        return OFF
    sigma = track[2]
    near = np.empty(WINDOW)
    for axis in range(3):
        if not math.isfinite(sigma[k, axis]):
            continue
        found = 0
        for n in range(among[1] - among[0]):
            m = nearest(among, k, n)
            if labels[m] == SOUND and math.isfinite(sigma[m, axis]) and found < WINDOW:
                near[found] = sigma[m, axis]
                found += 1
        if found >= LEAST and sigma[k, axis] > LESS_CERTAIN * np.median(near[:found]):
            return UNCERTAIN
    return SOUND


@part
def nearest(among: tuple[int, int], k: int, n: int) -> int:
    """Return the n-th frame of a range, counted from the end that lies nearest frame k."""
    return among[1] - 1 - n if among[1] <= k else among[0] + n


@part
def beyond(track: Track, labels: Labels, among: tuple[int, int], k: int) -> float:
    """Return how far a frame lies off the line through others, in what it may; 0 without a line.

    Parameters
    ----------
    labels, among
        The WINDOW frames nearest to it that are SOUND in this half-open range make the line.
    """
    tau, straight, sigma, bent = track
    most = 0.0
    for axis in range(3):
        if not math.isfinite(sigma[k, axis]):
            continue
        found, weight, first, second, value, product = 0, 0.0, 0.0, 0.0, 0.0, 0.0
        bow, skew = 0.0, 0.0
        for n in range(among[1] - among[0]):
            m = nearest(among, k, n)
            if labels[m] != SOUND or not math.isfinite(sigma[m, axis]) or found == WINDOW:
                continue
            found += 1
            own, late = sigma[m, axis] ** -2.0, tau[m] - tau[k]
            weight += own
            first += own * late
            second += own * late * late
            value += own * straight[m, axis]
            product += own * late * straight[m, axis]
            bow += own * bent[m, axis]
            skew += own * late * bent[m, axis]
        spread = weight * second - first * first
        if found < LEAST - 1 or not spread > 0.0:
            continue
        # At the frame's own time the line's height is its constant.
        expected = (second * value - first * product) / spread
        error = math.sqrt(second / spread + sigma[k, axis] ** 2)
        off = abs(straight[k, axis] - expected)
        by_air = abs(bent[k, axis] - (second * bow - first * skew) / spread)
        most = max(most, off / (MOST_SIGMAS * error + MOST_OFF_M + by_air))
    return most


GATE_SIGMAS, GATE_RAD = 4.0, 0.02
"""What an orientation may lie off a rate: so many of its errors and this angle besides."""
FINEST_RAD = 0.01
"""Error below which an orientation has no more weight."""
TRIED = 24
"""Frames through which rates are tried, evenly through the track."""
SHORTEST = 0.125
"""Of a pair of frames that gives a rate, share of the track."""
MOST_ASTRAY = 0.05
"""Share of the weight off the best rate that a robust fit bears."""
LEAST_TOGETHER, LEAST_IN_ONE_VIEW = 0.5, 0.8
"""Share of the weight that the best rate needs. In one view few markers are seen, and the run that
agrees may be the wrong one of two."""

LEAST_TURNS_CHECKED = 3
FARTHER = 1.5
"""Of the shortest time between orientations: rounded times vary by less."""


def agreeing_turns(
    times_s: Floats, rotations: Floats, sigma: Floats, *, least: float = LEAST_TOGETHER
) -> NDArray[np.bool_]:
    """Return which orientations of one side of a contact agree with one rate, shape (frames,).

    All of them where hardly any lies off it; none where less than `least` of their weight agrees,
    where two agree and others contradict them, as any two have a rate in common, or where none
    that agree are as close in time as others are: three at even distances have a rate in common
    with any that makes whole turns more in between.

    Parameters
    ----------
    times_s, sigma
        Times, s, and standard errors about each axis, slow ones included, rad, shape (frames,).
    rotations
        Body to rig axes, shape (frames, 3, 3).
    """
    count = len(times_s)
    if count < LEAST_TURNS_CHECKED:
        return np.ones(count, dtype=np.bool_)
    gate = GATE_SIGMAS * sigma + GATE_RAD
    weight = 1.0 / (sigma**2 + FINEST_RAD**2)
    steps = rotation_vector(rotations[1:] @ rotations[:-1].swapaxes(1, 2))
    rate = np.median(steps / np.diff(times_s)[:, None], axis=0)
    tried = np.unique(np.linspace(0, count - 1, TRIED).astype(np.intp))
    best, share = np.ones(count, dtype=np.bool_), 0.0
    for anchor in tried:
        since = times_s - times_s[anchor]
        expected = rotation_matrix(rate * since[:, None]) @ rotations[anchor]
        off = rotation_vector(rotations @ expected.swapaxes(1, 2))
        ends = tried[np.abs(since[tried]) > SHORTEST * np.ptp(times_s)]
        # The rate through the anchor and each of the ends, to first order in what it changes.
        changes = off[ends] / since[ends, None]
        left = off[None] - changes[:, None] * since[None, :, None]
        agree = (left**2).sum(axis=2) <= gate**2
        own = (agree * weight).sum(axis=1) / weight.sum()
        if own.max(initial=0.0) > share:
            share, best = float(own.max()), agree[own.argmax()]
        if share >= 1.0 - MOST_ASTRAY:
            return np.ones(count, dtype=np.bool_)
    sure = share >= least and best.sum() >= LEAST_TURNS_CHECKED
    # Whole turns in between are known only where two that agree are as close as any two.
    sure = sure and np.diff(times_s[best]).min() < FARTHER * np.diff(times_s).min()
    return best if sure else np.zeros(count, dtype=np.bool_)
