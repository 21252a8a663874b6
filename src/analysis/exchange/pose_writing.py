"""Writing poses.csv from poses that were read or stored before."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from analysis.exchange.pose_table import PoseRow
from analysis.exchange.tables import POSES


def write_pose_rows(
    path: Path, shots: Iterable[tuple[int, Mapping[str, Sequence[PoseRow]]]]
) -> None:
    """Write one row for each sphere and frame; what was not measured or stated stays empty.

    `read_poses` reads back the same numbers; of orientations, up to rounding their length to 1.
    """
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(POSES)
        for number, spheres in shots:
            for sphere, rows in spheres.items():
                writer.writerows(_fields(number, sphere, row) for row in rows)


def _fields(number: int, sphere: str, row: PoseRow) -> Iterator[object]:
    yield from (number, row.frame, row.t_s, sphere)
    for value in (*row.position, *row.position_sigma):
        yield value if math.isfinite(value) else ""
    yield from ("",) * 4 if row.quaternion is None else row.quaternion
    yield row.rotation_sigma if math.isfinite(row.rotation_sigma) else ""
