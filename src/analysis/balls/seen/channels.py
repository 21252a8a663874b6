"""Channels in which a ball's rim is measured: weights of the light of a picture's colours.

A ball that differs from its ground by c, in light of each colour, is seen best in the channel
C^-1 c, with the covariance C of what a model of ball and ground leaves of it (Fisher, 1936). What
is left is what a codec does, what a smooth shading cannot follow, and shadows that come and go;
which of them is the most differs from film to film.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.films.film import FilmHead, Picture
from analysis.balls.films.tone import BRIGHTNESS, light

Singles = NDArray[np.float32]

CODED_RADIUS_PX = 13.0
"""Larger balls of compressed films are fitted in pixels that are whole multiples of the film's."""
SHADE = 0.3
"""Standard deviation of a ground's light in shadows that come and go, over its light."""
ALIKE = 0.05
"""Difference of two channels' weights, of their size, up to which they are one."""
LEAST_BRIGHTNESS = 0.2
"""Of the largest difference of a channel, where brightness is taken for the rim."""
CODEC_LEVELS, MOST_CODEC_NOISE = 2.0, 0.3
"""Error of a channel's light, and what of it may be left of a ball's contrast of 1."""
SHADOW_WEIGHT = 25.0
"""By how much the ground's own colour counts as noise: shadows dim it and drop out."""


def patched_weights(ball: Singles, still: Singles) -> Floats:
    """Return weights for light at the rim of a ball with patches: brightness.

    Patches differ in brightness, most of all; a difference of colours that tells all of them from
    the ground is faint. Brightness is measured by squares: white and black may be as bright as the
    ground in the mean.
    """
    channels = ball.shape[1]
    weights = BRIGHTNESS if channels == len(BRIGHTNESS) else np.full(channels, 1.0 / channels)
    apart = (ball - still).astype(np.float64) @ weights
    return np.asarray(weights / max(math.sqrt(float((apart**2).mean())), 1e-9))


def rim_weights(ball: Singles, still: Singles, head: FilmHead, radius_px: float) -> Floats:
    """Return weights for light at the rim: brightness where a codec has halved the colours.

    Of a large ball half of the colours is enough, and a shadow on the wall behind it, which goes
    with it, drops out.
    """
    colours = _fisher(ball, still)
    if head.channels != 3 or not head.compressed:
        return colours
    faint = float(np.hypot.reduce(colours)) * CODEC_LEVELS > MOST_CODEC_NOISE
    difference = (ball.mean(axis=0) - still.mean(axis=0)).astype(np.float64)
    brightness = float(BRIGHTNESS @ difference)
    if _dark(difference) or (radius_px >= 2 * CODED_RADIUS_PX and not faint):
        return colours
    return BRIGHTNESS / brightness


def other_weights(
    values: tuple[Picture, Picture], terms: Floats, head: FilmHead, own: Floats
) -> tuple[Floats, ...]:
    """Return weights of other channels in which the ball may be seen better than in its own.

    That of a codec's error alone, that with what a smooth shading leaves and with shadows, and
    brightness. None where there is one colour.

    Parameters
    ----------
    values
        Pixels of the ball, and of what is behind them, shape (N, channels).
    terms
        Of the shading at each pixel, shape (N, TERMS).
    own
        Weights of its own channel.
    """
    if head.channels != len(BRIGHTNESS):
        return ()
    ball, still = (light(each, head).astype(np.float64) for each in values)
    difference, base = ball.mean(axis=0) - still.mean(axis=0), still.mean(axis=0)
    coded = np.diag(np.mean([_error(each, head) for each in values], axis=0) ** 2)
    left = ball - terms @ np.linalg.lstsq(terms, ball, rcond=None)[0]
    whole = coded + left.T @ left / len(left) + SHADE**2 * np.outer(base, base)
    found = [np.linalg.solve(coded, difference), np.linalg.solve(whole, difference)]
    if not _dark(difference):
        found.append(BRIGHTNESS)
    return _unlike([own, *(each / float(each @ difference) for each in found)])[1:]


def _error(values: Picture, head: FilmHead) -> Floats:
    """Return the error of light in each channel that so many levels of its values make."""
    least = CODEC_LEVELS if head.compressed else 1.0
    if not (head.encoded and values.dtype == np.uint8):
        return np.full(head.channels, least)
    middle = np.clip(np.rint(values.mean(axis=0)), 1, np.iinfo(values.dtype).max - 1)
    high, low = (light((middle + way).astype(values.dtype), head) for way in (1, -1))
    return np.asarray(0.5 * least * (high - low), np.float64)


def _dark(difference: Floats) -> bool:
    """Return whether brightness hardly tells a ball from its ground."""
    return bool(
        abs(float(BRIGHTNESS @ difference)) <= LEAST_BRIGHTNESS * float(np.abs(difference).max())
    )


def _unlike(channels: Sequence[Floats]) -> tuple[Floats, ...]:
    """Return channels that differ from all before them."""
    found: list[Floats] = []
    for each in channels:
        apart = [np.linalg.norm(each - other) / np.linalg.norm(each) for other in found]
        if not apart or min(apart) > ALIKE:
            found.append(each)
    return tuple(found)


def _fisher(ball: NDArray[np.generic], still: NDArray[np.generic]) -> Floats:
    inside, behind = np.asarray(ball, np.float64), np.asarray(still, np.float64)
    difference = inside.mean(axis=0) - behind.mean(axis=0)
    if len(difference) == 1:
        return np.asarray(1.0 / np.where(difference == 0, 1.0, difference))
    base = behind.mean(axis=0)
    within = [np.asarray(np.cov(each.T), dtype=np.float64) for each in (inside, behind)]
    spread = within[0] + within[1] + np.eye(len(difference))
    scale = float(np.trace(spread)) / len(difference)
    colour = np.outer(base, base) / float(base @ base)
    weights = np.linalg.solve(spread + SHADOW_WEIGHT * scale * colour, difference)
    return np.asarray(weights / float(weights @ difference))
