"""`rigctl precompile`: compile the analysis for this machine; no first shot waits for it."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.balls.analysis import AnalysedFilm, FilmJob, analyse_film
from analysis.balls.discs.disc import Disc
from analysis.balls.discs.finding import find_balls
from analysis.balls.flight.known import Ball
from analysis.balls.seen.placing import Placer
from analysis.balls.seen.windows import Motion, Window
from analysis.campaign import analyse_campaign, read_campaign
from analysis.effects.catalogue import CATALOGUE
from analysis.effects.contact import lasting_contact
from analysis.errors import ShotRefusedError
from analysis.imaging.outlines import Place
from analysis.model.data.gather import gather
from analysis.model.fitting.robust_fit import robust_fit
from analysis.model.verdict.selection import explain
from analysis.qualification.locating import locate
from analysis.shot import AnalysisOptions, Method
from analysis.workers import Workers
from rigctl.challenge import new
from rigctl.cli.output import progress

FILMED, TABULATED = 4, 20
"""Shots of the two small campaigns: one to be measured, one to be explained."""
RATE_HZ, FALL_PX_PER_S2, RADIUS_PX = 200.0, 2800.0, 14.0
TOP_PX, PLATE_PX, SHAPE, REBOUND = 40.0, 200.0, (240, 120), 0.8
"""Of the drawn film: a ball falls from rest onto a plate and bounces."""
RESTS_PX, RESTS_FRAMES = 120.0, 12
"""Of another one: the row at which a ball rests, and for how many frames."""
DISC_PX = 64
"""Side of the picture of one disc."""
SMEARED_SHAPE, HALF_AXES = (240, 320), (26, 21)
"""Of a picture of one disc that is smeared: a wide picture, and half as wide and high as it is."""


def precompile() -> None:
    """Measure a simulated campaign by both methods, drawn films and a disc, explain another.

    In two processes. What is compiled already takes seconds.

    Raises
    ------
    StoreError
        There is no room for temporary files.
    WorkerDiedError
        A process was killed.
    """
    with tempfile.TemporaryDirectory() as folder, Workers(2) as workers, progress() as report:
        filmed, tabulated = Path(folder) / "filmed", Path(folder) / "tabulated"
        new(filmed, seed=5, strength="full", shots=FILMED, from_frames=True)
        new(tabulated, seed=5, strength="full", shots=TABULATED)
        parts: list[Future[Any]] = [
            workers.submit(_measure, filmed, "photometric"),
            workers.submit(_explain, tabulated),
            workers.submit(_measure, filmed, "thesis"),
            workers.submit(measure_drawn_ball, Path(folder) / "ball"),
            workers.submit(look_for_resting_ball, Path(folder) / "rests"),
            workers.submit(locate_drawn_disc),
            workers.submit(find_smeared_disc),
            workers.submit(place_ball_with_patches),
        ]
        for done, part in enumerate(parts):
            report(f"compiling: {done} of {len(parts)} parts")
            part.result()


def _measure(folder: Path, method: Method) -> None:
    for _ in analyse_campaign(read_campaign(folder), AnalysisOptions(method=method), workers=1):
        pass


def _explain(folder: Path) -> None:
    data = gather(folder)[1]
    robust_fit(data, (lasting_contact.EFFECT,))
    explain(data, CATALOGUE)


def measure_drawn_ball(folder: Path) -> AnalysedFilm:
    """Draw a ball that falls and bounces once into a new folder, and measure it.

    Raises
    ------
    OSError
        There is no room for the film.
    """
    contact_s = np.sqrt(2.0 * (PLATE_PX - TOP_PX) / FALL_PX_PER_S2)
    rows = []
    for time_s in np.arange(0.0, 1.5 * contact_s, 1.0 / RATE_HZ):
        since = time_s if time_s < contact_s else time_s - contact_s
        up = REBOUND * FALL_PX_PER_S2 * contact_s
        begun, speed = (TOP_PX, 0.0) if time_s < contact_s else (PLATE_PX, -up)
        rows.append(begun + speed * since + 0.5 * FALL_PX_PER_S2 * since**2)
    return _analysed(folder, rows)


def look_for_resting_ball(folder: Path) -> str:
    """Draw a ball that rests into a new folder, and return why none is measured that flies.

    What is looked for then needs functions that the film of a flight does not.

    Raises
    ------
    OSError
        There is no room for the film.
    """
    try:
        _analysed(folder, [RESTS_PX] * RESTS_FRAMES)
    except ShotRefusedError as refused:
        return str(refused)
    return ""


def _analysed(folder: Path, rows: Sequence[float]) -> AnalysedFilm:
    folder.mkdir()
    rng = np.random.default_rng(1)
    for k, row in enumerate(rows):
        seen = np.full(SHAPE, 60, np.uint8)
        centre = round(16 * SHAPE[1] / 2), round(16 * row)
        cv2.circle(seen, centre, round(16 * RADIUS_PX), 200, cv2.FILLED, cv2.LINE_AA, 4)
        noisy = cv2.GaussianBlur(seen, (0, 0), 0.7) + rng.normal(0.0, 1.5, SHAPE)
        cv2.imwrite(str(folder / f"{k:04d}.png"), noisy.clip(0, 255).astype(np.uint8))
    diameter_m = 2 * RADIUS_PX / FALL_PX_PER_S2 * 9.80665
    return analyse_film(FilmJob(1, folder, Ball(diameter_m), rate_hz=RATE_HZ, exposure_s=0.0))


def locate_drawn_disc() -> Place:
    """Draw a disc in the middle and return where its edges are, as `rigctl qualify` finds it."""
    middle = DISC_PX / 2
    return locate(_drawn_disc()[None], [(middle, middle, RADIUS_PX)], "exact")[0]


def _drawn_disc() -> NDArray[np.uint8]:
    seen = np.full((DISC_PX, DISC_PX), 60, np.uint8)
    centre = (8 * DISC_PX, 8 * DISC_PX)
    cv2.circle(seen, centre, round(16 * RADIUS_PX), 200, cv2.FILLED, cv2.LINE_AA, 4)
    return np.asarray(cv2.GaussianBlur(seen, (0, 0), 0.7), np.uint8)


def find_smeared_disc() -> list[Disc]:
    """Draw a disc that is smeared to an oval, and look for discs and more that are like them."""
    seen = np.full(SMEARED_SHAPE, 8.0, np.float32)
    middle = SMEARED_SHAPE[1] // 2, SMEARED_SHAPE[0] // 2
    cv2.ellipse(seen, middle, HALF_AXES, 0, 0, 360, (240.0,), cv2.FILLED, cv2.LINE_AA)
    noise = np.random.default_rng(1).normal(0.0, 1.0, SMEARED_SHAPE)
    return find_balls(cv2.GaussianBlur(seen, (0, 0), 1.0) + noise, (6.0, 80.0))


def place_ball_with_patches() -> tuple[float, float]:
    """Draw a disc and return its place, (row, column) in px, as that of a ball with patches."""
    grey = _drawn_disc() / 60.0
    ground = np.ones_like(grey)
    window = Window(0, 0, 0, np.stack([grey, ground, ground, np.zeros_like(grey)]))
    start = Motion(np.zeros(1, np.intp), np.full((1, 2), DISC_PX / 2), np.zeros((1, 2)))
    row, column = Placer.new(RADIUS_PX, 0.0, patched=True).place([window], start).places[0]
    return float(row), float(column)
