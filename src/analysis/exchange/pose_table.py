"""Reading poses.csv: centre and orientation of both spheres in every frame."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

from analysis.exchange.rows import TableRow, read_rows
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
    shots: dict[int, dict[str, list[PoseRow]]] = defaultdict(lambda: {"a": [], "b": []})
    seen: set[tuple[int, int, str]] = set()
    for row in read_rows(path, POSES):
        sphere = row.fields["sphere"]
        if sphere not in {"a", "b"}:
            raise row.fault(f"sphere: {sphere!r} is neither a nor b")
        shot, pose = row.whole("shot"), _pose(row)
        if (shot, pose.frame, sphere) in seen:
            raise row.fault(f"shot {shot}, frame {pose.frame}, sphere {sphere} twice")
        seen.add((shot, pose.frame, sphere))
        shots[shot][sphere].append(pose)
    for spheres in shots.values():
        for poses in spheres.values():
            poses.sort(key=lambda pose: pose.frame)
    return dict(sorted(shots.items()))


def _pose(row: TableRow) -> PoseRow:
    place = [row.number(name) for name in _POSITION]
    sigma = [row.sigma(name) for name in _POSITION_SIGMA]
    measured = [p is not None and s is not None for p, s in zip(place, sigma, strict=True)]
    time = row.number("t_s")
    if time is None:
        raise row.fault("t_s: empty")
    quaternion, turn_sigma = _orientation(row)
    x, y, z = (
        p if p is not None and ok else math.nan for p, ok in zip(place, measured, strict=True)
    )
    u, v, w = (
        s if s is not None and ok else math.inf for s, ok in zip(sigma, measured, strict=True)
    )
    return PoseRow(row.whole("frame"), time, (x, y, z), (u, v, w), quaternion, turn_sigma)


def _orientation(row: TableRow) -> tuple[tuple[float, float, float, float] | None, float]:
    w, x, y, z = (row.number(name) for name in _QUATERNION)
    sigma = row.sigma("sigma_rot_rad")
    if w is None or x is None or y is None or z is None or sigma is None:
        return None, math.inf
    length = math.sqrt(w * w + x * x + y * y + z * z)
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        raise row.fault(f"qw..qz: a quaternion of length {length:.4g}, not 1")
    return (w / length, x / length, y / length, z / length), sigma
