"""A fitted campaign as what is computed of it after the fit goes over it, part by part."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from analysis.model.data.parts import Keeper, in_memory, parts_of
from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.summary import FitSummary
from analysis.model.predict.state import ShotStates


@dataclass(frozen=True, slots=True, eq=False)
class Passes:
    """A campaign and its fit, to be gone over as often as wanted.

    Attributes
    ----------
    shots
        Numbers of the shots, shape (S,).
    jitter_s
        Standard deviation of each frame's time that the data were given, s.
    fit
        What was found.
    parts
        Begins a pass: data and states of so many shots at a time, in order.
    keep
        Where to keep what has a number for each shot.
    """

    shots: NDArray[np.intp]
    jitter_s: float
    fit: FitSummary
    parts: Callable[[], Iterator[tuple[Data, ShotStates]]]
    keep: Keeper


def passes_of(data: Data, fit: Fit) -> Passes:
    """Return the passes over a campaign in memory."""
    parts = partial(parts_of, data, fit.states)
    return Passes(data.shots, data.jitter_s, fit, parts, in_memory)
