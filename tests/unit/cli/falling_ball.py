"""Small drawn films of a ball of 28 px that falls and bounces, and what `rigctl analyse` says."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from rigctl import cli

Capsys = pytest.CaptureFixture[str]

Drawn = NDArray[np.uint8]
SHAPE, RADIUS, RATE, FALL = (240, 120), 14.0, 200.0, 2800.0
"""A ball of 28 px whose fall is 2800 px/s^2: 100 mm across."""
GROUND, BALL = 60.0, 200.0
FINE, BLURRED = 8, 5
"""Parts of a pixel, and how far beyond the ball its blur reaches, px."""
DIAMETER_MM = 2 * RADIUS / FALL * 9806.65
SIZE = ("--ball-diameter-mm", f"{DIAMETER_MM:.3f}", "--exposure-us", "0")

ON_A_PLATE = """
format = 1
name = "drops"
[camera]
frame_rate_hz = {rate_hz}
width_px = 120
height_px = 240
[[spheres]]
name = "a"
diameter_m = {diameter_m}
[[spheres]]
name = "b"
plate = true
"""
"""Set-up of a campaign of films of such a ball."""


@lru_cache(maxsize=2000)
def picture(row: float, column: float = 60.0) -> Drawn:
    """Draw the ball as a lens and a sensor do: blurred first, and then summed over each pixel.

    A disc that is blurred on the grid of pixels has a rim that moves with its place between them,
    by 0.005 px where each pixel is drawn with four by four. Many films show the same bounces: what
    was drawn is kept.
    """
    grey = np.full(SHAPE, GROUND)
    (top, bottom), (left, right) = (
        (max(int(at - RADIUS) - BLURRED, 0), max(min(int(at + RADIUS) + BLURRED + 1, size), 0))
        for at, size in zip((row, column), SHAPE, strict=True)
    )
    rows = (np.arange(top * FINE, bottom * FINE) + 0.5)[:, None] / FINE - 0.5
    columns = (np.arange(left * FINE, right * FINE) + 0.5) / FINE - 0.5
    within = np.clip(FINE * (RADIUS - np.hypot(rows - row, columns - column)) + 0.5, 0.0, 1.0)
    if within.size:
        within = cv2.GaussianBlur(within, (0, 0), 0.7 * FINE)
    parts = within.reshape(max(bottom - top, 0), FINE, max(right - left, 0), FINE)
    grey[top:bottom, left:right] += (BALL - GROUND) * parts.mean(axis=(1, 3))
    noise = np.random.default_rng(int(1e3 * abs(row))).normal(0.0, 1.5, SHAPE)
    drawn = np.asarray(np.clip(np.rint(grey + noise), 0, 255), np.uint8)
    drawn.flags.writeable = False
    return drawn


def write(folder: Path, rows: list[float], columns: list[float] | None = None) -> Path:
    places = zip(rows, columns or [60.0] * len(rows), strict=True)
    return save(folder, [picture(row, column) for row, column in places])


def save(folder: Path, pictures: Sequence[Drawn]) -> Path:
    folder.mkdir()
    for k, each in enumerate(pictures):
        cv2.imwrite(str(folder / f"{k:04d}.png"), each)
    return folder


def bouncing(count: int = 100, e: float = 0.8, per_frame: int = 1) -> list[float]:
    plate, speed, begun, rows = 200.0, 0.0, 0.0, []
    top = 40.0
    contact = (2 * (plate - top) / FALL) ** 0.5
    for t in np.arange(count) / (per_frame * RATE):
        while t > contact:
            speed = e * (FALL * (contact - begun) - speed if begun else FALL * contact)
            # What bounces by less than a fiftieth of a pixel rests.
            lasts = 2 * speed / FALL if speed > 10.0 else np.inf
            begun, contact = contact, contact + lasts
        down = top + 0.5 * FALL * t**2 if begun == 0.0 else plate if contact == np.inf else None
        gone = t - begun
        rows.append(plate - speed * gone + 0.5 * FALL * gone**2 if down is None else down)
    return rows


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    """Return the one shot of a film; the command says by its end whether it was measured."""
    code = cli.run(["analyse", *arguments, "--json"])
    shown = capsys.readouterr()
    (shot,) = json.loads(shown.out)["shots"]
    assert code == (0 if shot["status"] == "measured" else cli.BAD_INPUT)
    assert (shot["status"] == "measured") or shot["reason"] in shown.err
    return dict(shot)


def analysed(pictures: list[Drawn], folder: Path, capsys: Capsys, rate: int = 200) -> Any:
    film = save(folder / "film", pictures)
    shot = answer(capsys, str(film), *SIZE, "--fps", str(rate))
    assert shot["status"] == "measured", shot
    return shot


def said(shot: Any, words: str) -> str:
    """Return the note with these words; fail where none has them."""
    notes = [note for note in shot["notes"] if words in note]
    assert len(notes) == 1, shot["notes"]
    return str(notes[0])
