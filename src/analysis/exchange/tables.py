"""The columns of poses.csv and contacts.csv, and writing the contacts of measured shots."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from analysis.collision.impact import ContactState
from analysis.shot import MeasuredShot

if TYPE_CHECKING:
    from _csv import Writer

Floats = NDArray[np.float64]

WriteShot = Callable[[int, MeasuredShot], object]
"""Adds a measured shot under its number."""

POSES = [
    *("shot", "frame", "t_s", "sphere"),
    *("x_m", "y_m", "z_m", "sigma_x_m", "sigma_y_m", "sigma_z_m"),
    *("qw", "qx", "qy", "qz", "sigma_rot_rad"),
]
POSES_SLOW = ["slow_position_m", "slow_rotation_rad"]
"""May stand in poses.csv: slow errors of a shot, in each of its rows, where they are its own."""
_STATE = [f"{kind}{sphere}_{axis}" for kind in "vw" for sphere in "ab" for axis in "xyz"]
CONTACT_SIGMAS = [f"sigma_{name}{suffix}" for suffix in ("", "_after") for name in _STATE]
"""May stand in contacts.csv: standard errors of single numbers, m/s and rad/s."""
DURATION = ["duration_s", "sigma_duration_s"]
"""May stand in contacts.csv: how long a contact lasts, where that was measured, s."""
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
def contact_writer(path: Path) -> Iterator[WriteShot]:
    """Give a function that adds a shot to contacts.csv: one row for each.

    Beside the sigma of each number stand the root mean squares over axes and spheres. What was not
    measured stays empty.
    """
    with table_writer(path, [*CONTACTS, *CONTACT_SIGMAS]) as table:
        yield lambda number, shot: table.writerow(_contact(number, shot))


@contextmanager
def table_writer(path: Path, names: list[str]) -> Iterator[Writer]:
    """Give a CSV file with its heading written."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(names)
        yield table


def _contact(number: int, shot: MeasuredShot) -> list[object]:
    impact = shot.impact
    return [
        number,
        *map(float, impact.normal),
        *(_field(x) for state in (impact.before, impact.after) for x in _numbers(state)),
        *(_field(_mean(impact.state_sigma[:, part])) for part in (slice(0, 2), slice(2, 4))),
        *(_field(sigma) for sigma in impact.state_sigma.ravel()),
    ]


def _mean(sigmas: Floats) -> float:
    """Return the root mean square of those that are known, not a number where none is."""
    known = sigmas[np.isfinite(sigmas)]
    return float(np.sqrt((known**2).mean())) if known.size else float("nan")


def _field(value: float) -> object:
    return float(value) if np.isfinite(value) else ""


def _numbers(state: ContactState) -> list[float]:
    parts = (state.velocity_a, state.velocity_b, state.spin_a, state.spin_b)
    return [float(value) for part in parts for value in part]
