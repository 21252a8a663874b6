"""Where the misfit of fits is least as one number of theirs is tried, and how sure that is."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from analysis.arrays import Floats

RADII = (0.8, 0.88, 0.94, 1.0, 1.06, 1.13, 1.22, 1.32)
"""In radii of the rim; what a smooth shading can hide lies between."""
HARDLY_WORSE = 0.04
"""Rise of the misfit over its least up to which an exposure may be: codecs blur, and a light that
was learned with one exposure explains that one best."""
LEAST_MISFIT, MOST_MISFIT = 1e-12, 10.0
"""Sum of squares that a fit leaves, and how many times its least one frame counts for at most."""


def about(tried: Sequence[float], value: float) -> list[float]:
    """Return the values next to one, itself among them: where it is sought again."""
    k = int(np.searchsorted(tried, value))
    own = k < len(tried) and tried[k] == value
    above = tried[k + own : k + own + 2 - (k > 0)]
    return [*tried[max(0, k - 1) : k], value, *above]


def together(
    misfits: Callable[[float], Floats], tried: Sequence[float]
) -> Callable[[float], float]:
    """Return the mean of the curves of several frames, each in units of its least value.

    A frame in which a shadow lies under the ball leaves much whatever is tried, and counts for
    little.
    """
    known = {value: misfits(value) for value in tried}
    lowest = np.maximum(np.min(list(known.values()), axis=0), LEAST_MISFIT)
    told = np.isfinite(lowest)

    def misfit(value: float) -> float:
        own = known[value] if value in known else misfits(value)
        shares = np.minimum(own[told] / lowest[told], MOST_MISFIT)
        return float(shares.mean()) if told.any() else np.inf

    return misfit


def falls_to(best: float, misfits: Sequence[float]) -> bool:
    """Return whether misfits of `RADII` fall steadily from the rim's to the least of them."""
    rim, least = RADII.index(1.0), int(np.argmin(np.abs(np.array(RADII) - best)))
    first, last = min(rim, least), max(rim, least)
    steps = np.diff(misfits[first : last + 1])
    return bool((steps <= 0.0).all() if least > rim else (steps >= 0.0).all())


def least(misfit: Callable[[float], float], tried: Sequence[float]) -> float:
    """Return where a curve is least: by a parabola through the best of some values, twice."""
    values = list(tried)
    misfits = [misfit(value) for value in values]
    for _ in range(2):
        k = int(np.argmin(misfits))
        if k in (0, len(values) - 1) or not np.isfinite(misfits[k - 1 : k + 2]).all():
            break
        bend, slope, _ = np.polyfit(
            np.array(values[k - 1 : k + 2]) - values[k], misfits[k - 1 : k + 2], 2
        )
        if bend <= 0:
            break
        value = float(np.clip(values[k] - slope / (2 * bend), values[k - 1], values[k + 1]))
        if value in values:
            break
        at = int(np.searchsorted(values, value))
        values.insert(at, value)
        misfits.insert(at, misfit(value))
    return values[int(np.argmin(misfits))]


def unsure(misfit: Callable[[float], float], tried: Sequence[float], found: float) -> float:
    """Return how far from the value of least misfit others are hardly worse, on average of sides.

    At a bound of what is tried there is one side; where a side has none that is worse, the larger
    of both.
    """
    most = (1.0 + HARDLY_WORSE) * misfit(found)
    sides, closed = [], True
    for beyond in ([v for v in tried if v > found], [v for v in reversed(tried) if v < found]):
        at, before, rises = found, misfit(found), False
        for value in beyond:
            here = misfit(value)
            rises = here > most
            share = (most - before) / (here - before) if rises else 1.0
            at, before = at + share * (value - at), here
            if rises:
                break
        if beyond:
            sides.append(abs(at - found))
            closed &= rises
    return float(np.mean(sides)) if closed else max(sides)
