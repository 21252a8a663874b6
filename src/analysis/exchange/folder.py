"""Writing an exchange folder: from analysed shots, or from the bounces of a ball's film."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from analysis.campaign import DESCRIPTION, SHOT_LIST, ShotJob
from analysis.exchange.contact_table import contact_writer
from analysis.exchange.description import description
from analysis.exchange.impact_table import QUANTITIES, SIGMAS, ImpactRow
from analysis.exchange.pose_table import pose_writer
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


@dataclass(frozen=True, slots=True)
class MeasuredBounce:
    """A bounce: its film and its number there, speeds along the normal with errors, m/s.

    Attributes
    ----------
    film, bounce
        Numbers, counted from 1.
    v_n, sigma_v_n
        Before the bounce, negative.
    v_n_after, sigma_v_n_after
        After it.
    """

    film: int
    bounce: int
    v_n: float
    sigma_v_n: float
    v_n_after: float
    sigma_v_n_after: float


def write_bounces(folder: Path, name: str, setup: Setup, bounces: Sequence[MeasuredBounce]) -> None:
    """Write an exchange folder: campaign.toml, shots.csv and impacts.csv.

    The columns `film` and `bounce` name the source of each shot. Speeds along the plate are left
    empty, since spin is not measured.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    rows = [
        ShotRow(number, None, {"film": float(each.film), "bounce": float(each.bounce)}, {})
        for number, each in enumerate(bounces, start=1)
    ]
    unknown = math.nan
    impacts = [
        ImpactRow(
            number,
            (each.v_n, unknown, each.v_n_after, unknown),
            (each.sigma_v_n, None, each.sigma_v_n_after, None),
        )
        for number, each in enumerate(bounces, start=1)
    ]
    write_impacts(folder, description(name, setup), rows, impacts)


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
