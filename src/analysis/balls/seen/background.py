"""What stands still in a film: the middle of each pixel's values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from analysis.balls.films.film import Picture
from analysis.compiled import compiled

Singles = NDArray[np.float32]


def background(samples: list[Picture]) -> Picture:
    """Return the median of some frames, of their shape and kind."""
    stacked = cast("Picture", np.stack(samples))
    flat = stacked.reshape(len(samples), -1)
    return cast("Picture", _medians(flat).reshape(stacked.shape[1:]))


def background_without(samples: Sequence[Singles], hidden: Sequence[NDArray[np.bool_]]) -> Singles:
    """Return the median of some frames where none of them shows the ball.

    Parameters
    ----------
    samples
        Light of each, shape (rows, columns).
    hidden
        Of each, where the ball is; shape (rows, columns). A pixel that it hides in all keeps the
        median of all.
    """
    flat = np.stack(samples).reshape(len(samples), -1)
    mask = np.stack(hidden).reshape(len(samples), -1)
    return np.asarray(_seen_medians(flat, mask).reshape(samples[0].shape))


@compiled
def _seen_medians(values: Singles, hidden: NDArray[np.bool_]) -> Singles:
    """Return the upper median of what is not hidden in each column; of all where all is."""
    count, width = values.shape
    found = np.empty(width, values.dtype)
    line = np.empty(count, values.dtype)
    for j in range(width):
        seen = 0
        for k in range(count):
            if not hidden[k, j]:
                seen += 1
        every = seen == 0
        many = 0
        for k in range(count):
            if hidden[k, j] and not every:
                continue
            i = many
            while i > 0 and line[i - 1] > values[k, j]:
                line[i] = line[i - 1]
                i -= 1
            line[i] = values[k, j]
            many += 1
        found[j] = line[many // 2]
    return found


@compiled
def _medians(values: Picture) -> Picture:
    """Return the upper median of each column, by insertion."""
    count, width = values.shape
    found = np.empty(width, values.dtype)
    block = 4096
    sorted_ = np.empty((block, count), values.dtype)
    for start in range(0, width, block):
        many = min(block, width - start)
        for k in range(count):
            for j in range(many):
                value = values[k, start + j]
                i = k
                while i > 0 and sorted_[j, i - 1] > value:
                    sorted_[j, i] = sorted_[j, i - 1]
                    i -= 1
                sorted_[j, i] = value
        for j in range(many):
            found[start + j] = sorted_[j, count // 2]
    return found
