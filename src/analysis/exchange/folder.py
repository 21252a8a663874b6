"""Writing an exchange folder from analysed shots."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from analysis.campaign import DESCRIPTION, SHOT_LIST, ShotJob
from analysis.exchange.description import FORMAT
from analysis.exchange.pose_writing import pose_writer
from analysis.exchange.shot_list import ShotRow
from analysis.exchange.tables import WriteShot, contact_writer
from analysis.setup import DRAG_SIGMA, Setup, SlowErrors
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


def description(name: str, setup: Setup) -> str:
    """Return campaign.toml; what the set-up does not know is left out."""
    camera = setup.camera
    fields = {
        "frame_rate_hz": camera.frame_rate_hz,
        "width_px": camera.width_px,
        "height_px": camera.height_px,
        "scale_px_per_m": camera.scale_px_per_m,
        "front_view_rows": camera.front_view_rows,
        "top_view_rows": camera.top_view_rows,
        "front_origin_px": camera.front_origin_px,
        "top_origin_px": camera.top_origin_px,
    }
    # JSON writes these numbers and lists as TOML does.
    lines = [f"format = {FORMAT}", f"name = {_quoted(name)}", "[camera]"]
    lines += [f"{key} = {json.dumps(value)}" for key, value in fields.items() if value is not None]
    for sphere in setup.spheres:
        lines += [
            "[[spheres]]",
            f"name = {json.dumps(sphere.name)}",
            f"diameter_m = {sphere.diameter_m}",
            f"density_kg_per_m3 = {sphere.density_kg_per_m3}",
            f"inertia_factor = {sphere.inertia_factor}",
        ]
    lines += [
        "[environment]",
        f"gravity_m_per_s2 = {setup.gravity_m_per_s2}",
        f"air_density_kg_per_m3 = {setup.air_density_kg_per_m3}",
    ]
    if setup.drag_coefficient is not None:
        lines.append(f"drag_coefficient = {setup.drag_coefficient}")
    if setup.drag_coefficient is not None or setup.drag_sigma != DRAG_SIGMA:
        lines.append(f"drag_coefficient_sigma = {setup.drag_sigma}")
    if setup.slow.stated or not setup.slow.one_body_frame:
        lines += [
            "[measurement]",
            f"slow_position_m = {setup.slow.position_m}",
            f"slow_rotation_rad = {setup.slow.rotation_rad}",
            f"scale_sigma = {setup.slow.scale}",
            f"slow_memory_rad = {setup.slow.memory_rad}",
            f"one_body_frame = {json.dumps(setup.slow.one_body_frame)}",
        ]
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    """Return a TOML string: as in JSON, but TOML takes no surrogate pairs and no bare delete."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


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
