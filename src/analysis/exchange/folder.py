"""Writing an exchange folder: from analysed shots, from films of a ball, or from a table."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from analysis.campaign import DESCRIPTION, SHOT_LIST, ShotJob
from analysis.exchange.contact_table import contact_writer
from analysis.exchange.description import description
from analysis.exchange.impact_table import QUANTITIES, SIGMAS, ImpactRow
from analysis.exchange.pose_table import PoseRow, pose_writer, write_pose_rows
from analysis.exchange.rows import WriteShot
from analysis.exchange.shot_list import ShotRow
from analysis.setup import Setup, SlowErrors
from analysis.shot import MeasuredShot
from analysis.slow_errors import typical


@contextmanager
def folder_writer(folder: Path, name: str, jobs: Sequence[ShotJob]) -> Iterator[WriteShot]:
    """Give a function that adds a measured shot to an exchange folder.

    poses.csv and contacts.csv grow shot by shot, and no shot is held. campaign.toml and shots.csv
    are written at the end: a folder without them was cut short. A refused shot has its row in
    shots.csv and none in the others.

    Parameters
    ----------
    jobs
        All of the campaign's, one at least; the first one's set-up is the campaign's.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / DESCRIPTION).unlink(missing_ok=True)
    errors: list[SlowErrors] = []
    with (
        pose_writer(folder / "poses.csv") as write_poses,
        contact_writer(folder / "contacts.csv") as write_contact,
    ):

        def write(number: int, shot: MeasuredShot) -> None:
            write_poses(number, shot)
            write_contact(number, shot)
            errors.append(shot.slow)

        yield write
    setup = typical(next(iter(jobs)).setup, errors)
    _write_rows(folder / SHOT_LIST, _columns(_rows(jobs)), _rows(jobs))
    (folder / DESCRIPTION).write_text(description(name, setup), encoding="utf-8")


def _rows(jobs: Sequence[ShotJob]) -> Iterator[ShotRow]:
    return (job.row or ShotRow(job.shot, None, {}, {}) for job in jobs)


def write_shot_list(path: Path, rows: Sequence[ShotRow]) -> None:
    """Write shots.csv: number and time, numeric columns and words, each in alphabetical order."""
    _write_rows(path, _columns(rows), rows)


def _columns(rows: Iterable[ShotRow]) -> tuple[list[str], list[str]]:
    """Return the names of the numeric columns and of the words that any row has."""
    numbers, words = set[str](), set[str]()
    for row in rows:
        numbers |= row.numbers.keys()
        words |= row.words.keys()
    return sorted(numbers), sorted(words)


def _write_rows(path: Path, columns: tuple[list[str], list[str]], rows: Iterable[ShotRow]) -> None:
    numbers, words = columns
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["shot", "time", *numbers, *words])
        for row in rows:
            time = "" if row.time is None else row.time.isoformat()
            values = [row.numbers.get(n, "") for n in numbers] + [
                row.words.get(w, "") for w in words
            ]
            writer.writerow([row.shot, time, *values])


IMPACTS = "impacts.csv"


def write_ball_poses(
    folder: Path, name: str, setup: Setup, shots: Mapping[int, Sequence[PoseRow]]
) -> None:
    """Write an exchange folder of a ball beside a plate: campaign.toml, shots.csv and poses.csv.

    A table of impacts that lies there is taken away: it would be read in their place.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / IMPACTS).unlink(missing_ok=True)
    (folder / DESCRIPTION).write_text(description(name, setup), encoding="utf-8")
    write_shot_list(folder / SHOT_LIST, [ShotRow(shot, None, {}, {}) for shot in shots])
    write_pose_rows(folder / "poses.csv", ((shot, {"a": rows}) for shot, rows in shots.items()))


def write_impacts(
    folder: Path, described: str, rows: Sequence[ShotRow], impacts: Sequence[ImpactRow]
) -> None:
    """Write an exchange folder: campaign.toml as it is `described`, shots.csv and impacts.csv.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / DESCRIPTION).write_text(described, encoding="utf-8")
    write_shot_list(folder / SHOT_LIST, rows)
    with (folder / IMPACTS).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["shot", *QUANTITIES, *SIGMAS])
        for each in impacts:
            speeds = ["" if math.isnan(speed) else speed for speed in each.speeds]
            sigmas = ["" if sigma is None else sigma for sigma in each.sigmas]
            writer.writerow([each.shot, *speeds, *sigmas])
