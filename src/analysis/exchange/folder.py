"""Writing an exchange folder from analysed shots."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from analysis.campaign import DESCRIPTION, SHOT_LIST, ShotJob
from analysis.exchange.description import description
from analysis.exchange.pose_writing import pose_writer
from analysis.exchange.shot_list import ShotRow
from analysis.exchange.tables import WriteShot, contact_writer
from analysis.setup import SlowErrors
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
