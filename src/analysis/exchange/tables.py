"""poses.csv and contacts.csv: what the analysis hands on."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from analysis.collision.impact import ContactState
from analysis.motion.rotation import quaternion
from analysis.shot import MeasuredShot

if TYPE_CHECKING:
    from _csv import Writer

WriteShot = Callable[[int, MeasuredShot], object]
"""Adds a measured shot under its number."""

POSES = [
    *("shot", "frame", "t_s", "sphere"),
    *("x_m", "y_m", "z_m", "sigma_x_m", "sigma_y_m", "sigma_z_m"),
    *("qw", "qx", "qy", "qz", "sigma_rot_rad"),
]
_STATE = [f"{kind}{sphere}_{axis}" for kind in "vw" for sphere in "ab" for axis in "xyz"]
CONTACTS = [
    "shot",
    "nx",
    "ny",
    "nz",
    *_STATE,
    *(f"{name}_after" for name in _STATE),
    "sigma_v_m_per_s",
    "sigma_w_rad_per_s",
]


@contextmanager
def pose_writer(path: Path) -> Iterator[WriteShot]:
    """Give a function that adds a shot to poses.csv: one row for each sphere and frame.

    What was not measured stays empty.
    """
    with _table(path, POSES) as table:
        yield lambda number, shot: table.writerows(_poses(number, shot))


@contextmanager
def contact_writer(path: Path) -> Iterator[WriteShot]:
    """Give a function that adds a shot to contacts.csv: one row for each.

    The sigmas are root mean squares over axes and spheres.
    """
    with _table(path, CONTACTS) as table:
        yield lambda number, shot: table.writerow(_contact(number, shot))


@contextmanager
def _table(path: Path, names: list[str]) -> Iterator[Writer]:
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(names)
        yield table


def _poses(number: int, shot: MeasuredShot) -> Iterator[list[object]]:
    times = shot.times_s - shot.times_s[0]
    for name, centres, turned in zip("ab", shot.centres, shot.orientations, strict=True):
        where = {int(k): i for i, k in enumerate(turned.frames)}
        for k, position, sigma in zip(centres.frames, centres.position, centres.sigma, strict=True):
            placed: list[object]
            orientation: list[object] = [""] * 5
            if (i := where.get(int(k))) is not None:
                spread = float(np.sqrt(np.trace(turned.covariance[i]) / 3))
                orientation = [*map(float, quaternion(turned.rotation[i])), spread]
            seen = np.isfinite(sigma)
            placed = [float(p) if ok else "" for p, ok in zip(position, seen, strict=True)]
            placed += [float(s) if ok else "" for s, ok in zip(sigma, seen, strict=True)]
            yield [number, int(k), float(times[k]), name, *placed, *orientation]


def _contact(number: int, shot: MeasuredShot) -> list[object]:
    impact = shot.impact
    spread = np.sqrt((impact.state_sigma**2).mean(axis=(0, 2)))
    return [
        number,
        *map(float, impact.normal),
        *_numbers(impact.before),
        *_numbers(impact.after),
        float(np.sqrt((spread[:2] ** 2).mean())),
        float(np.sqrt((spread[2:] ** 2).mean())),
    ]


def _numbers(state: ContactState) -> list[float]:
    parts = (state.velocity_a, state.velocity_b, state.spin_a, state.spin_b)
    return [float(value) for part in parts for value in part]
