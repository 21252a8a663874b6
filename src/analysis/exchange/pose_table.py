"""poses.csv, read and written: centre and orientation of both spheres in every frame."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import chain, groupby
from pathlib import Path

import numpy as np

from analysis.arrays import Floats
from analysis.exchange.numbers_seen import NumbersSeen
from analysis.exchange.rows import TableRow, WriteShot, each_row, read_rows, table_writer
from analysis.motion.rotation import quaternion
from analysis.setup import SlowErrors
from analysis.shot import MeasuredShot
from analysis.shot_poses import isotropic

POSES = [
    *("shot", "frame", "t_s", "sphere"),
    *("x_m", "y_m", "z_m", "sigma_x_m", "sigma_y_m", "sigma_z_m"),
    *("qw", "qx", "qy", "qz", "sigma_rot_rad"),
]
POSES_SLOW = ["slow_position_m", "slow_rotation_rad"]
"""May stand in poses.csv: slow errors of a shot, in each of its rows, where they are its own."""
POSES_TURN = [f"cov_rot_{axes}_rad2" for axes in ("xx", "yy", "zz", "xy", "xz", "yz")]
"""May stand in poses.csv: covariance of a small turn about X, Y and Z, where one axis is less well
known; `sigma_rot_rad` is the root of its mean on the diagonal."""
_FURTHER = [*POSES_SLOW, *POSES_TURN]
_POSITION = ("x_m", "y_m", "z_m")
_POSITION_SIGMA = ("sigma_x_m", "sigma_y_m", "sigma_z_m")
_QUATERNION = ("qw", "qx", "qy", "qz")
_UNIT_TOLERANCE = 1e-3
_SIZE_TOLERANCE = 0.01
"""Of a covariance's size against the standard error that stands beside it."""


TurnCovariance = tuple[float, float, float, float, float, float]


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
    turn_covariance
        xx, yy, zz, xy, xz and yz of a small turn in rig axes, rad^2, its mean variance the square
        of `rotation_sigma`; None: the same about each axis.
    """

    frame: int
    t_s: float
    position: tuple[float, float, float]
    position_sigma: tuple[float, float, float]
    quaternion: tuple[float, float, float, float] | None
    rotation_sigma: float
    slow: tuple[float, float] | None = None
    turn_covariance: TurnCovariance | None = None


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
        negative, a quaternion that is not of length 1, a covariance that is none or contradicts
        its sigma, a frame that stands twice; with the line.
    """
    rows: dict[int, list[TableRow]] = defaultdict(list)
    for row in read_rows(path, POSES, _FURTHER):
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
    for shot, own in groupby(each_row(path, POSES, _FURTHER), lambda row: row.whole("shot")):
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
    spread = None if quaternion is None else _turn_covariance(row, turn_sigma)
    return PoseRow(
        row.whole("frame"), time, (x, y, z), (u, v, w), quaternion, turn_sigma, slow, spread
    )


def turn_matrix(spread: TurnCovariance) -> Floats:
    """Return the covariance of a small turn, rad^2, shape (3, 3)."""
    xx, yy, zz, xy, xz, yz = spread
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _turn_covariance(row: TableRow, sigma: float) -> TurnCovariance | None:
    given = [row.number(name) for name in POSES_TURN]
    xx, yy, zz, xy, xz, yz = given
    if xx is None or yy is None or zz is None or xy is None or xz is None or yz is None:
        if any(each is not None for each in given):
            raise row.fault(f"{','.join(POSES_TURN)}: all of them, or none")
        return None
    spread = xx, yy, zz, xy, xz, yz
    least = float(np.linalg.eigvalsh(turn_matrix(spread))[0])
    if not least > 0.0:
        raise row.fault(f"cov_rot: no covariance, its least variance is {least:.3g} rad^2")
    size = math.sqrt((xx + yy + zz) / 3)
    if not abs(size - sigma) <= _SIZE_TOLERANCE * size:
        raise row.fault(
            f"sigma_rot_rad is {sigma:.4g}, and {size:.4g} by the covariance of the turn; it is "
            "the root of the mean of cov_rot_xx, yy and zz"
        )
    return spread


def _orientation(row: TableRow) -> tuple[tuple[float, float, float, float] | None, float]:
    w, x, y, z = (row.number(name) for name in _QUATERNION)
    sigma = row.sigma("sigma_rot_rad")
    if w is None or x is None or y is None or z is None:
        return None, math.inf
    length = math.sqrt(w * w + x * x + y * y + z * z)
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        raise row.fault(f"qw..qz: a quaternion of length {length:.4g}, not 1")
    return (w / length, x / length, y / length, z / length), math.nan if sigma is None else sigma


@contextmanager
def pose_writer(path: Path) -> Iterator[WriteShot]:
    """Give a function that adds a measured shot to poses.csv: one row for each sphere and frame.

    What was not measured stays empty.
    """
    with table_writer(path, [*POSES, *_FURTHER]) as table:
        yield lambda number, shot: table.writerows(
            _rows(number, measured_poses(shot), with_slow=True, with_turn=True)
        )


def measured_poses(shot: MeasuredShot) -> dict[str, list[PoseRow]]:
    """Return the poses of a measured shot in the form of poses.csv.

    Frames that may have been exposed during the contact are left out: they show no single state,
    and a reader of poses cannot recognise them.
    """
    times = shot.times_s - shot.times_s[0]
    slow = shot.slow.position_m, shot.slow.rotation_rad
    spheres: dict[str, list[PoseRow]] = {}
    for name, centres, turned in zip("ab", shot.centres, shot.orientations, strict=True):
        where = {int(k): i for i, k in enumerate(turned.frames)}
        spreads = isotropic(turned.covariance)
        spheres[name] = []
        for k, place, sigma in zip(centres.frames, centres.position, centres.sigma, strict=True):
            if int(k) in shot.between:
                continue
            at, spread, turn = None, math.inf, None
            if (i := where.get(int(k))) is not None:
                w, x, y, z = map(float, quaternion(turned.rotation[i]))
                at, spread = (w, x, y, z), float(spreads[i])
                turn = _six(turned.covariance[i])
            px, py, pz = map(float, place)
            sx, sy, sz = map(float, sigma)
            place_and_error = (px, py, pz), (sx, sy, sz)
            spheres[name].append(
                PoseRow(int(k), float(times[k]), *place_and_error, at, spread, slow, turn)
            )
    return spheres


def _six(covariance: Floats) -> TurnCovariance:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = covariance.tolist()
    return xx, yy, zz, xy, xz, yz


def write_pose_rows(
    path: Path, shots: Iterable[tuple[int, Mapping[str, Sequence[PoseRow]]]]
) -> None:
    """Write one row for each sphere and frame; what was not measured or stated stays empty.

    `read_poses` reads back the same numbers; of orientations, up to rounding their length to 1.
    """
    ordered = iter(shots)
    first = next(ordered, None)
    with_slow = first is not None and any(
        row.slow is not None for rows in first[1].values() for row in rows
    )
    with_turn = first is not None and any(
        row.turn_covariance is not None for rows in first[1].values() for row in rows
    )
    further = [*(POSES_SLOW if with_slow else ()), *(POSES_TURN if with_turn else ())]
    with table_writer(path, [*POSES, *further]) as table:
        for number, spheres in chain([] if first is None else [first], ordered):
            table.writerows(_rows(number, spheres, with_slow=with_slow, with_turn=with_turn))


def _rows(
    number: int, spheres: Mapping[str, Sequence[PoseRow]], *, with_slow: bool, with_turn: bool
) -> Iterator[list[object]]:
    for sphere, rows in spheres.items():
        for row in rows:
            slow: tuple[object, ...] = row.slow or ("", "")
            turn: tuple[object, ...] = row.turn_covariance or ("",) * len(POSES_TURN)
            yield [
                *_fields(number, sphere, row),
                *(slow if with_slow else ()),
                *(turn if with_turn else ()),
            ]


def _fields(number: int, sphere: str, row: PoseRow) -> Iterator[object]:
    yield from (number, row.frame, row.t_s, sphere)
    for value in (*row.position, *row.position_sigma):
        yield value if math.isfinite(value) else ""
    yield from ("",) * 4 if row.quaternion is None else row.quaternion
    yield row.rotation_sigma if math.isfinite(row.rotation_sigma) else ""
