"""Writing impacts.csv: bounces of a ball on a plate, each a shot of its own."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from analysis.campaign import DESCRIPTION, SHOT_LIST
from analysis.exchange.description import description
from analysis.exchange.folder import write_shot_list
from analysis.exchange.impact_table import QUANTITIES, SIGMAS
from analysis.exchange.shot_list import ShotRow
from analysis.setup import Setup

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
    folder.mkdir(parents=True, exist_ok=True)
    (folder / DESCRIPTION).write_text(description(name, setup), encoding="utf-8")
    rows = [
        ShotRow(number, None, {"film": float(each.film), "bounce": float(each.bounce)}, {})
        for number, each in enumerate(bounces, start=1)
    ]
    write_shot_list(folder / SHOT_LIST, rows)
    with (folder / IMPACTS).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["shot", *QUANTITIES, *SIGMAS])
        for number, each in enumerate(bounces, start=1):
            speeds = [each.v_n, "", each.v_n_after, ""]
            writer.writerow([number, *speeds, each.sigma_v_n, "", each.sigma_v_n_after, ""])
