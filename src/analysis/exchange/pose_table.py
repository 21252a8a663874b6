"""Reading poses.csv: centre and orientation of both spheres in every frame."""

from __future__ import annotations

import csv
import math
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

from analysis.errors import InputError, counted
from analysis.exchange.tables import POSES

_POSITION = ("x_m", "y_m", "z_m")
_POSITION_SIGMA = ("sigma_x_m", "sigma_y_m", "sigma_z_m")
_QUATERNION = ("qw", "qx", "qy", "qz")
_UNIT_TOLERANCE = 1e-3


@dataclass(frozen=True, slots=True)
class PoseRow:
    """One sphere in one frame; what was not measured is None.

    Attributes
    ----------
    t_s
        From the shot's first frame, s.
    position, position_sigma
        m in rig axes; a coordinate that was not measured is NaN with an infinite sigma.
    quaternion
        Scalar first, body to rig axes, of length 1.
    rotation_sigma
        About each axis, rad.
    """

    frame: int
    t_s: float
    position: tuple[float, float, float]
    position_sigma: tuple[float, float, float]
    quaternion: tuple[float, float, float, float] | None
    rotation_sigma: float


def read_poses(path: Path) -> dict[int, dict[str, list[PoseRow]]]:
    """Read poses.csv into shots and spheres, rows in the order of their frames.

    Raises
    ------
    InputError
        Absent, a column missing or unknown, a field that is no number, a sigma that is not
        positive, a quaternion that is not of length 1, a frame that stands twice; with the line.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.reader(file))
    except FileNotFoundError as error:
        raise InputError(path, "no such file") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(path, f"not CSV in UTF-8: {error}") from error
    if not rows or sorted(rows[0]) != sorted(POSES):
        raise InputError(path, f"the columns must be {','.join(POSES)}", 1)
    shots: dict[int, dict[str, list[PoseRow]]] = defaultdict(lambda: {"a": [], "b": []})
    seen: set[tuple[int, int, str]] = set()
    for line, fields in enumerate(rows[1:], start=2):
        if not fields:
            continue
        if len(fields) != len(rows[0]):
            found = counted(len(fields), "field")
            raise InputError(path, f"{found} for {len(rows[0])} columns", line)
        row = dict(zip(rows[0], fields, strict=True))
        sphere = row["sphere"]
        if sphere not in {"a", "b"}:
            raise InputError(path, f"sphere: {sphere!r} is neither a nor b", line)
        shot, pose = _whole(path, line, row, "shot"), _pose(path, line, row)
        if (shot, pose.frame, sphere) in seen:
            raise InputError(path, f"shot {shot}, frame {pose.frame}, sphere {sphere} twice", line)
        seen.add((shot, pose.frame, sphere))
        shots[shot][sphere].append(pose)
    for spheres in shots.values():
        for poses in spheres.values():
            poses.sort(key=lambda pose: pose.frame)
    return dict(sorted(shots.items()))


def _pose(path: Path, line: int, row: dict[str, str]) -> PoseRow:
    place = [_number(path, line, row, name) for name in _POSITION]
    sigma = [_number(path, line, row, name) for name in _POSITION_SIGMA]
    for name, value in zip(_POSITION_SIGMA, sigma, strict=True):
        if value is not None and value <= 0:
            raise InputError(path, f"{name}: {value} is not a positive standard error", line)
    measured = [p is not None and s is not None for p, s in zip(place, sigma, strict=True)]
    time = _number(path, line, row, "t_s")
    if time is None:
        raise InputError(path, "t_s: empty", line)
    quaternion, turn_sigma = _orientation(path, line, row)
    x, y, z = (
        p if p is not None and ok else math.nan for p, ok in zip(place, measured, strict=True)
    )
    u, v, w = (
        s if s is not None and ok else math.inf for s, ok in zip(sigma, measured, strict=True)
    )
    frame = _whole(path, line, row, "frame")
    return PoseRow(frame, time, (x, y, z), (u, v, w), quaternion, turn_sigma)


def _orientation(
    path: Path, line: int, row: dict[str, str]
) -> tuple[tuple[float, float, float, float] | None, float]:
    parts = [_number(path, line, row, name) for name in _QUATERNION]
    sigma = _number(path, line, row, "sigma_rot_rad")
    w, x, y, z = parts
    if w is None or x is None or y is None or z is None or sigma is None:
        return None, math.inf
    length = math.sqrt(w * w + x * x + y * y + z * z)
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        raise InputError(path, f"qw..qz: a quaternion of length {length:.4g}, not 1", line)
    if sigma <= 0:
        raise InputError(path, f"sigma_rot_rad: {sigma} is not a positive standard error", line)
    return (w / length, x / length, y / length, z / length), sigma


def _number(path: Path, line: int, row: dict[str, str], name: str) -> float | None:
    field = row[name].strip()
    if not field:
        return None
    try:
        value = float(field)
    except ValueError as error:
        raise InputError(path, f"{name}: {field!r} is not a number", line) from error
    if not math.isfinite(value):
        raise InputError(path, f"{name}: {field!r} is not finite", line)
    return value


def _whole(path: Path, line: int, row: dict[str, str], name: str) -> int:
    try:
        return int(row[name])
    except ValueError as error:
        raise InputError(path, f"{name}: {row[name]!r} is not a whole number", line) from error
