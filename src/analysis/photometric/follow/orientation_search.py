"""Orientation of a known sphere without a start value: its markers on dark places of the frame."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from analysis.arrays import Floats
from analysis.compiled import compiled
from analysis.photometric.follow.confirmation import shown_share
from analysis.photometric.follow.film import cost_of
from analysis.photometric.render.camera import disc_of
from analysis.photometric.render.pose import fit_pose
from analysis.photometric.render.residual import LOOK, hidden, shade
from analysis.photometric.render.sight import Sight, Stance

STEP_RAD = 0.14
LEAST_FACING = 0.3
TRIED = 30
CLEAR_COST, DOUBTFUL_COST, CLEAR_SHARE, CLEAR_MARKERS = 2.0, 4.0, 0.85, 3
"""A trial that costs less than the first, with so many markers as dark as expected
(`confirmation`), is accepted at once; one below the second, if few others come near.

A false turn of a sphere whose markers are known costs 2.4 at least and may show 0.86 of their
darkness; where some are not known the true one may cost as much."""
RIVAL_SHARE = 0.45
"""An orientation of the grid whose predicted gain is below this share of the best one's fitted gain
is no rival. Where markers are not known and one view alone is seen, a truth may be
among those."""
APART_RAD = 0.25
CERTAIN_GAP = 25.0
"""Five standard deviations, squared."""
LIMITS = np.array([40.0, 40.0, 20.0, 10.0, 6.0])


class Found(NamedTuple):
    """The orientation that fits best.

    Attributes
    ----------
    cost
        Its `film.cost_of`; infinite where the markers cannot be seen at all.
    gap
        By how much chi-squared of the best other orientation exceeds its own, in units of what it
        is for a pixel; infinite where the best is clear by itself.
    """

    cost: float
    stance: Stance
    gap: float

    @property
    def certain(self) -> bool:
        """Whether no other orientation fits as well: two markers alone may be exchanged."""
        return self.gap > CERTAIN_GAP


@lru_cache(maxsize=1)
def turns() -> Floats:
    """Return rotations spread over all orientations, about STEP_RAD apart, shape (n, 3, 3).

    Turns about each of evenly spread directions (a spiral over the sphere).
    """
    around = math.ceil(2 * math.pi / STEP_RAD)
    count = math.ceil(4 * math.pi / STEP_RAD**2)
    k = np.arange(count) + 0.5
    tilt, azimuth = np.arccos(1 - 2 * k / count), np.pi * (1 + math.sqrt(5)) * k
    angles = np.stack(
        np.broadcast_arrays(
            azimuth[:, None], tilt[:, None], 2 * np.pi * np.arange(around)[None, :] / around
        ),
        axis=-1,
    )
    return np.asarray(Rotation.from_euler("ZYZ", angles.reshape(-1, 3)).as_matrix())


@compiled
def darkness_of(sight: Sight, stance: Stance, view: int, dark: Floats) -> None:
    """Fill a square of (row, column) offsets from -1 to 1 with the darkness against plain shading.

    0 where the disc is not seen; shape (n, n).
    """
    look, scene = sight.look, sight.scene
    place = disc_of(sight.optics, view, stance.centre, look.radius_m)
    seen = np.zeros(LOOK)
    half = (dark.shape[0] - 1) / 2
    rows = sight.optics.rows[view]
    for i in range(dark.shape[0]):
        u = i / half - 1.0
        for j in range(dark.shape[1]):
            v = j / half - 1.0
            if u * u + v * v > 0.95:
                continue
            y, x = int(np.rint(place[0] + place[2] * u)), int(np.rint(place[1] + place[2] * v))
            if y < max(rows[0], 0) or y >= rows[1] or x < 0 or x >= scene.image.shape[1]:
                continue
            if hidden(scene, y, x, sight.others[view]):
                continue
            shade(look.discs[view], look.surfaces[view], u, v, seen)
            plain = max(seen[3], 3.0 * scene.noise)
            dark[i, j] = min(max((plain - scene.image[y, x]) / plain, -0.3), 1.0)


@compiled
def scores(
    dark: Floats, axes: Floats, marked: tuple[Floats, float], rotations: Floats, out: Floats
) -> None:
    """Add for each rotation what its markers explain of the darkness, over all views.

    A marker of darkness D on a place of darkness d takes D (2 d - D) off the sum of squares: one
    where nothing is dark counts against a rotation as much as one that fits counts for it.

    Parameters
    ----------
    dark
        Of each view, shape (V, n, n).
    axes
        Of each view, shape (V, 3, 3).
    marked
        Directions of the markers in body axes, shape (M, 3), and their darkness.
    out
        Added to, shape (rotations,).
    """
    half, into, (markers, darkness) = (dark.shape[1] - 1) / 2, np.empty((3, 3)), marked
    for view in range(dark.shape[0]):
        for n in range(rotations.shape[0]):
            for a in range(3):
                for b in range(3):
                    into[a, b] = 0.0
                    for k in range(3):
                        into[a, b] += axes[view, a, k] * rotations[n, k, b]
            for m in range(markers.shape[0]):
                x, y, w = markers[m, 0], markers[m, 1], markers[m, 2]
                z = into[2, 0] * x + into[2, 1] * y + into[2, 2] * w
                if z < LEAST_FACING:
                    continue
                u = into[0, 0] * x + into[0, 1] * y + into[0, 2] * w
                v = into[1, 0] * x + into[1, 1] * y + into[1, 2] * w
                i, j = int((u + 1) * half + 0.5), int((v + 1) * half + 0.5)
                if dark[view, i, j] != 0.0:
                    out[n] += z * (dark[view, i, j] - darkness / 2)


def search_orientation(sight: Sight, stance: Stance, candidates: Floats) -> Found:
    """Return the stance whose rendering fits best.

    Parameters
    ----------
    stance
        Centre within about 1 pixel; its rotation is not used.
    candidates
        Of `turns`.
    """
    dark = _darkness(sight, stance)
    total, fulfilled = _promise(dark, sight, candidates), 0.0
    trials: list[tuple[float, Stance]] = []
    best, pixels, covariance = Found(math.inf, stance, math.inf), 0.0, np.zeros((6, 6))
    for _ in range(TRIED):
        n = int(total.argmax())
        if best.cost < DOUBTFUL_COST and total[n] < RIVAL_SHARE * fulfilled:
            break
        trial = Stance(stance.centre.copy(), candidates[n].copy(), stance.lights.copy())
        out = fit_pose(sight, trial, LIMITS, covariance)
        cost = float(cost_of(out, LIMITS[-1]))
        trials.append((cost, trial))
        if cost < best.cost:
            best, pixels = Found(cost, trial, math.inf), float(out[2])
            share, seen = shown_share(sight, trial)
            sure = share > CLEAR_SHARE and seen >= CLEAR_MARKERS
            fulfilled = float(_promise(dark, sight, trial.rotation[None])[0]) if sure else 0.0
            if cost < CLEAR_COST and sure:
                return best
        total[_near(candidates[n], candidates)] = -np.inf
    turned = np.stack([trial.rotation for _, trial in trials])
    others = np.flatnonzero(~_near(best.stance.rotation, turned))
    rival = min((trials[n][0] for n in others), default=math.inf)
    return best._replace(gap=(rival - best.cost) * pixels / max(best.cost, 1.0))


def _darkness(sight: Sight, stance: Stance) -> Floats:
    """Return `darkness_of` each view, shape (V, n, n)."""
    views = len(sight.optics.scales)
    size = 2 * int(np.clip(sight.look.radius_m * sight.optics.scales[0], 12, 40)) + 1
    dark = np.zeros((views, size, size))
    for view in range(views):
        darkness_of(sight, stance, view, dark[view])
    return dark


def _promise(dark: Floats, sight: Sight, rotations: Floats) -> Floats:
    """Return the `scores` of orientations, shape (n, 3, 3)."""
    total, marked = np.zeros(len(rotations)), (sight.look.markers, float(sight.look.darkness))
    scores(dark, sight.optics.axes, marked, np.ascontiguousarray(rotations), total)
    return total


def _near(rotation: Floats, others: Floats) -> NDArray[np.bool_]:
    """Return which orientations, shape (n, 3, 3), are less than APART_RAD from one."""
    traces = others.reshape(len(others), 9) @ rotation.reshape(9)
    return np.asarray(traces > 1 + 2 * math.cos(APART_RAD))
