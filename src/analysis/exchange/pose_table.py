"""Reading poses.csv: centre and orientation of both spheres in every frame."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

from analysis.exchange.numbers_seen import NumbersSeen
from analysis.exchange.rows import TableRow, each_row, read_rows
from analysis.exchange.tables import POSES, POSES_SLOW
from analysis.setup import SlowErrors

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
        m in rig axes; a coordinate that was not measured is NaN with an infinite sigma, one whose
        error is not stated has a sigma of NaN.
    quaternion
        Scalar first, body to rig axes, of length 1.
    rotation_sigma
        About each axis, rad; NaN: not stated.
    slow
        Size of what the frames of this flight share, of a coordinate in m and about each axis in
        rad; None: as campaign.toml states it.
    """

    frame: int
    t_s: float
    position: tuple[float, float, float]
    position_sigma: tuple[float, float, float]
    quaternion: tuple[float, float, float, float] | None
    rotation_sigma: float
    slow: tuple[float, float] | None = None


Spheres = dict[str, list[PoseRow]]
"""Rows of spheres a and b, in the order of their frames."""


def own_slow_errors(spheres: Mapping[str, Sequence[PoseRow]], stated: SlowErrors) -> SlowErrors:
    """Return the slow errors of one shot: as its rows have them, else as the campaign states."""
    for rows in spheres.values():
        for row in rows:
            if row.slow is not None:
                return replace(stated, position_m=row.slow[0], rotation_rad=row.slow[1])
    return stated


def read_poses(path: Path) -> dict[int, Spheres]:
    """Read poses.csv into shots and spheres, rows in the order of their frames.

    Raises
    ------
    InputError
        Absent, a column missing or unknown, a field that is no number, a sigma that is
        negative, a quaternion that is not of length 1, a frame that stands twice; with the line.
    """
    rows: dict[int, list[TableRow]] = defaultdict(list)
    for row in read_rows(path, POSES, POSES_SLOW):
        rows[row.whole("shot")].append(row)
    return {shot: _spheres(own) for shot, own in sorted(rows.items())}


def each_shot(path: Path) -> Iterator[tuple[int, Spheres]]:
    """Read poses.csv as `read_poses`, a shot at a time in the order of the file.

    Raises
    ------
    InputError
        As `read_poses`, and where the rows of a shot do not follow each other.
    """
    seen = NumbersSeen()
    for shot, own in groupby(each_row(path, POSES, POSES_SLOW), lambda row: row.whole("shot")):
        rows = list(own)
        if not seen.add(shot):
            raise rows[0].fault(
                f"shot {shot} goes on after others; sort the rows by shot to have them read a "
                "shot at a time"
            )
        yield shot, _spheres(rows)


def _spheres(rows: Iterable[TableRow]) -> Spheres:
    """Return the poses of one shot."""
    spheres: Spheres = {"a": [], "b": []}
    seen: set[tuple[int, str]] = set()
    for row in rows:
        sphere = row.fields["sphere"]
        if sphere not in spheres:
            raise row.fault(f"sphere: {sphere!r} is neither a nor b")
        pose = _pose(row)
        if (pose.frame, sphere) in seen:
            shot = row.whole("shot")
            raise row.fault(f"shot {shot}, frame {pose.frame}, sphere {sphere} twice")
        seen.add((pose.frame, sphere))
        spheres[sphere].append(pose)
    for poses in spheres.values():
        poses.sort(key=lambda pose: pose.frame)
    return spheres


def _pose(row: TableRow) -> PoseRow:
    place = [row.number(name) for name in _POSITION]
    sigma = [row.sigma(name) for name in _POSITION_SIGMA]
    time = row.number("t_s")
    if time is None:
        raise row.fault("t_s: empty")
    quaternion, turn_sigma = _orientation(row)
    x, y, z = (math.nan if p is None else p for p in place)
    u, v, w = (
        math.inf if p is None else math.nan if s is None else s
        for p, s in zip(place, sigma, strict=True)
    )
    place_slow, turn_slow = (row.number(name) for name in POSES_SLOW)
    slow = None if place_slow is None or turn_slow is None else (place_slow, turn_slow)
    if slow is not None and min(slow) < 0:
        raise row.fault(f"{' and '.join(POSES_SLOW)}: {slow} are sizes, and not negative")
    return PoseRow(row.whole("frame"), time, (x, y, z), (u, v, w), quaternion, turn_sigma, slow)


def _orientation(row: TableRow) -> tuple[tuple[float, float, float, float] | None, float]:
    w, x, y, z = (row.number(name) for name in _QUATERNION)
    sigma = row.sigma("sigma_rot_rad")
    if w is None or x is None or y is None or z is None:
        return None, math.inf
    length = math.sqrt(w * w + x * x + y * y + z * z)
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        raise row.fault(f"qw..qz: a quaternion of length {length:.4g}, not 1")
    return (w / length, x / length, y / length, z / length), math.nan if sigma is None else sigma
