"""Writing poses.csv: poses of measured shots, or such as were read or stored before."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain
from pathlib import Path

from analysis.exchange.pose_table import PoseRow
from analysis.exchange.tables import POSES, POSES_SLOW, WriteShot, table_writer
from analysis.motion.rotation import quaternion
from analysis.shot import MeasuredShot
from analysis.shot_poses import isotropic


@contextmanager
def pose_writer(path: Path) -> Iterator[WriteShot]:
    """Give a function that adds a measured shot to poses.csv: one row for each sphere and frame.

    What was not measured stays empty.
    """
    with table_writer(path, [*POSES, *POSES_SLOW]) as table:
        yield lambda number, shot: table.writerows(
            _rows(number, measured_poses(shot), with_slow=True)
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
            at, spread = None, math.inf
            if (i := where.get(int(k))) is not None:
                w, x, y, z = map(float, quaternion(turned.rotation[i]))
                at, spread = (w, x, y, z), float(spreads[i])
            px, py, pz = map(float, place)
            sx, sy, sz = map(float, sigma)
            row = PoseRow(int(k), float(times[k]), (px, py, pz), (sx, sy, sz), at, spread, slow)
            spheres[name].append(row)
    return spheres


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
    with table_writer(path, [*POSES, *POSES_SLOW] if with_slow else POSES) as table:
        for number, spheres in chain([] if first is None else [first], ordered):
            table.writerows(_rows(number, spheres, with_slow=with_slow))


def _rows(
    number: int, spheres: Mapping[str, Sequence[PoseRow]], *, with_slow: bool
) -> Iterator[list[object]]:
    for sphere, rows in spheres.items():
        for row in rows:
            slow: tuple[object, ...] = row.slow or ("", "")
            yield [*_fields(number, sphere, row), *(slow if with_slow else ())]


def _fields(number: int, sphere: str, row: PoseRow) -> Iterator[object]:
    yield from (number, row.frame, row.t_s, sphere)
    for value in (*row.position, *row.position_sigma):
        yield value if math.isfinite(value) else ""
    yield from ("",) * 4 if row.quaternion is None else row.quaternion
    yield row.rotation_sigma if math.isfinite(row.rotation_sigma) else ""
