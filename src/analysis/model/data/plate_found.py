"""How a plate lies whose normal nobody states, from the breaks in the flights beside it.

The centres of a sphere that touches a plane lie in a plane, and the change of its velocity is along
the normal but for friction. Both are taken together.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.exchange.pose_table import PoseRow
from analysis.model.data.plate import LEVEL, LEVEL_WITHIN_RAD, Plate, stated_plate
from analysis.setup import Setup

Shots = Iterable[Mapping[str, Sequence[PoseRow]]]

SIDE = 4
"""Frames of a straight line on either side of a contact."""
LEAST_KINK, LEAST_SIGMAS = 0.3, 8.0
"""Change of velocity over the larger speed, and over its standard error, from which it is one."""
FRICTION_RAD = 0.2
"""By how much friction turns the change of velocity off the normal; contacts have it in common."""
PLACE_M = 2e-4
"""Of a centre at contact, between frames."""
FLAT_M = 2e-3
"""Centres at contact scatter by more about their plane where the plate was moved between shots."""
NOT_LEVEL_RAD, MOST_SIGMAS = 0.1, 4.0
"""From where on a plate is not taken for level."""
GUESSED_SIGMA_M = 2e-5
HELD = 1e12


@dataclass(frozen=True, slots=True, eq=False)
class Kinks:
    """Breaks in flights: centres, m, and changes of velocity, m/s, of shape (K, 3).

    Attributes
    ----------
    shown
        Which axes the frames show, shape (3,).
    """

    centres: Floats
    changes: Floats
    shown: NDArray[np.bool_]


def plate_of(setup: Setup, shots: Shots) -> Plate:
    """Return the plate as it is stated, else as the shots show it; level where they show no other.

    Parameters
    ----------
    shots
        Rows of sphere a of each shot.
    """
    body = setup.spheres[1]
    if not body.plate or body.normal is not None:
        return stated_plate(body)
    gravity = setup.environment.gravity_m_per_s2
    return plate_through([kinks_of(spheres["a"], gravity) for spheres in shots])


def plate_through(kinks: Sequence[Kinks]) -> Plate:
    """Return the plate on which spheres broke their flights; a level one unless it clearly leans.

    The plate stands still in all shots, else the directions alone count.
    """
    centres = np.concatenate([np.zeros((0, 3)), *(own.centres for own in kinks)])
    changes = np.concatenate([np.zeros((0, 3)), *(own.changes for own in kinks)])
    if len(changes) == 0:
        return LEVEL
    hidden = ~np.any([own.shown for own in kinks if len(own.centres)], axis=0)
    ways = changes / np.linalg.norm(changes, axis=1, keepdims=True)
    by_ways = (np.eye(3) - ways.T @ ways / len(ways)) / FRICTION_RAD**2 + HELD * np.diag(hidden)
    about = centres - centres.mean(axis=0)
    values, vectors = np.linalg.eigh(by_ways + about.T @ about / PLACE_M**2)
    if np.sqrt(np.mean((about @ vectors[:, 0]) ** 2)) > FLAT_M:
        values, vectors = np.linalg.eigh(by_ways)
    normal = vectors[:, 0] * -np.sign(vectors[:, 0] @ ways.sum(axis=0))
    sigma = float(np.clip(values[1] ** -0.5, LEVEL_WITHIN_RAD, FRICTION_RAD))
    lean = float(np.arccos(np.clip(normal[0], -1.0, 1.0)))
    if lean < max(NOT_LEVEL_RAD, MOST_SIGMAS * sigma):
        return LEVEL
    normal = np.where(hidden, 0.0, normal)
    x, y, z = normal / np.linalg.norm(normal)
    return Plate((float(x), float(y), float(z)), sigma)


def kinks_of(rows: Sequence[PoseRow], gravity: float) -> Kinks:
    """Return the breaks of one shot's flights, which are straight but for gravity along +X."""
    places = np.array([row.position for row in rows]).reshape(-1, 3)
    shown = np.asarray(np.isfinite(places).any(axis=0))
    known = np.isfinite(places[:, shown]).all(axis=1)
    none = Kinks(np.zeros((0, 3)), np.zeros((0, 3)), shown)
    if known.sum() < 2 * SIDE + 1 or not shown.any():
        return none
    times = np.array([row.t_s for row in rows])[known]
    straight = np.where(shown, places, 0.0)[known]
    straight[:, 0] -= 0.5 * gravity * times**2
    middle, mean, slope, spread = _lines(times, straight)
    # Around frame k: the lines of the SIDE frames before it, and of those after it.
    before, after = slice(0, -SIDE - 1), slice(SIDE + 1, None)
    change = slope[after] - slope[before]
    size = np.linalg.norm(change, axis=1)
    fastest = np.linalg.norm(slope, axis=1)
    sigma = _sigma(rows, known) * np.sqrt(1.0 / spread[before] + 1.0 / spread[after])
    clear = size > np.maximum(
        LEAST_KINK * np.maximum(fastest[before], fastest[after]), LEAST_SIGMAS * sigma
    )
    padded = np.pad(size, SIDE, constant_values=0.0)
    largest = size >= sliding_window_view(padded, 2 * SIDE + 1).max(axis=1)
    found = np.flatnonzero(clear & largest)
    if found.size == 0:
        return none
    later = found + SIDE + 1
    gap = (mean[later] - slope[later] * middle[later, None]) - (
        mean[found] - slope[found] * middle[found, None]
    )
    time = -(gap * change[found]).sum(axis=1) / size[found] ** 2
    lines = [mean[k] + slope[k] * (time - middle[k])[:, None] for k in (found, later)]
    centres = 0.5 * (lines[0] + lines[1])
    centres[:, 0] += 0.5 * gravity * time**2
    return Kinks(centres, change[found], shown)


def _lines(times: Floats, values: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return middle time, mean and slope of values, and spread of times, of all SIDE frames."""
    own, numbers = sliding_window_view(times, SIDE), sliding_window_view(values, SIDE, axis=0)
    middle = own.mean(axis=1)
    offset = own - middle[:, None]
    spread = (offset**2).sum(axis=1)
    slope = (numbers * offset[:, None]).sum(axis=2) / spread[:, None]
    return middle, numbers.mean(axis=2), slope, spread


def _sigma(rows: Sequence[PoseRow], known: NDArray[np.bool_]) -> float:
    sigmas = np.array([row.position_sigma for row in rows])[known]
    stated = sigmas[np.isfinite(sigmas)]
    return float(np.median(stated)) if stated.size else GUESSED_SIGMA_M
