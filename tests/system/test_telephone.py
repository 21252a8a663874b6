"""A telephone films a shot: somebody says that it records, and brings its film, by command."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import httpx
import numpy as np
import pytest

from tests.system.real_rig import KEY, RIGCTL, WAIT_S, until

PLATE = Path(__file__).parents[2] / "config" / "simulated-plate.toml"
CAMERA = """
[camera]
kind = "film"
frame_rate_hz = 240.0
rows = 360
columns = 160
corner = [20, 10]
start_timeout_s = 100.0
collect_timeout_s = 300.0
frames_before_mark = 5
frames_after_mark = 220
exposure_us = 500.0
"""
SHOT = ("shot", "--pressure-kpa", "0", "--offset-mm", "0")
RESTITUTION = 0.8
BALL_MM, BALL_PX = 25.4, 36.0
STILL = 60
"""Frames before the ball falls, and pictures that the file says are played a second."""


def film(path: Path, frames: int = 360, played_per_s: float = 30.0) -> None:
    """Draw a ball that falls on a plate, at rest before, as a telephone at 240 frames/s saves it.

    Places are those of free flight with the restitution above, with no word of the program.
    """
    fall = 9.80665e3 * BALL_PX / BALL_MM
    top, plate = 60.0, 340.0
    rows, columns = np.mgrid[:400, :180]
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), played_per_s, (180, 400))
    random = np.random.default_rng(3)
    contact, begun, speed = float(np.sqrt(2 * (plate - top) / fall)), 0.0, 0.0
    for t in np.maximum((np.arange(frames) - STILL) / 240.0, 0.0):
        while t > contact:
            arrives = speed if begun else fall * contact
            begun, speed = contact, RESTITUTION * arrives
            contact = begun + 2 * speed / fall
        row = top + 0.5 * fall * t**2
        if begun:
            row = plate - speed * (t - begun) + 0.5 * fall * (t - begun) ** 2
        light = np.clip(BALL_PX / 2 + 0.5 - np.hypot(rows - row, columns - 90), 0, 1)
        grey = 60 + 150 * light + random.normal(0, 1.5, rows.shape)
        video.write(cv2.cvtColor(np.clip(grey, 0, 255).astype(np.uint8), cv2.COLOR_GRAY2BGR))
    video.release()


@dataclass
class Rig:
    folder: Path
    url: str

    def start(self, *words: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [*RIGCTL, *words, "--config", "rig.toml", "--json"],
            cwd=self.folder,
            env={**os.environ, "RIGCTL_KEY": KEY},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def command(self, *words: str) -> tuple[int, str, str]:
        process = self.start(*words)
        out, err = process.communicate(timeout=2 * WAIT_S)
        return process.returncode, out, err

    def waits_for(self) -> str:
        answer = httpx.get(
            f"{self.url}/api/v1/rig/film",
            headers={"Authorization": f"Bearer {KEY}"},
            trust_env=False,
            timeout=WAIT_S,
        )
        return str(answer.json()["waits_for"])


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rig]:
    folder = tmp_path_factory.mktemp("telephone")
    plate = PLATE.read_text(encoding="utf-8")
    begin, end = plate.index("[camera]"), plate.index("[store]")
    text = plate[:begin] + CAMERA + plate[end:]
    text = text.replace("front_view_rows = [0, 192]", "front_view_rows = [0, 360]")
    (folder / "rig.toml").write_text(text.replace("[96.0, 120.0]", "[180.0, 80.0]"))
    film(folder / "drop.mp4")
    film(folder / "short.mp4", frames=100)
    written = folder / "data-plate" / "service.json"
    with (folder / "serve.log").open("w") as log:
        daemon = subprocess.Popen(
            [*RIGCTL, "serve", "--config", "rig.toml", "--port", "0"],
            cwd=folder,
            env={**os.environ, "RIGCTL_KEY": KEY},
            stdout=log,
            stderr=log,
        )
    try:
        until(lambda: daemon.poll() is not None or written.exists(), WAIT_S)
        assert daemon.poll() is None, (folder / "serve.log").read_text()
        opened = Rig(folder, str(json.loads(written.read_text())["url"]))
        until(lambda: _lives(opened.url), WAIT_S)
        yield opened
    finally:
        daemon.terminate()
        daemon.wait(WAIT_S)


def _lives(url: str) -> bool:
    try:
        return httpx.get(f"{url}/health/live", trust_env=False).is_success
    except httpx.TransportError:
        return False


def test_nothing_is_taken_while_no_shot_waits(rig: Rig) -> None:
    assert rig.waits_for() == "nothing"
    for words in (("--records",), ("drop.mp4",), ("--gives-up",)):
        code, _, said = rig.command("film", *words)
        assert code == 3, said
        assert "no shot waits" in said


def test_a_shot_is_fired_at_a_persons_word_and_measured_from_the_film_that_is_brought(
    rig: Rig,
) -> None:
    shot = rig.start(*SHOT, "--wait-s", "300")
    until(lambda: shot.poll() is not None or rig.waits_for() == "recording", WAIT_S)
    assert shot.poll() is None, shot.communicate()
    code, _, said = rig.command("film", "drop.mp4")
    assert code == 3, said
    assert rig.command("film", "--records")[0] == 0
    until(lambda: rig.waits_for() == "film", WAIT_S)

    code, _, said = rig.command("film", "short.mp4")
    assert code == 2, said
    assert "100 frames" in said
    assert "225" in said
    assert rig.waits_for() == "film"

    code, said, wrong = rig.command("film", "drop.mp4")
    assert code == 0, wrong
    out, err = shot.communicate(timeout=5 * WAIT_S)
    assert shot.returncode == 0, err
    result = json.loads(out)["result"]
    first = result["impacts"][0]["e"]
    assert abs(first["value"] - RESTITUTION) < 4 * first["sigma"] + 0.002
    assert first["sigma"] < 0.02


def test_a_shot_without_a_film_is_given_up_and_the_next_one_waits_anew(rig: Rig) -> None:
    shot = rig.start(*SHOT)
    until(lambda: rig.waits_for() == "recording", WAIT_S)
    assert rig.command("film", "--gives-up")[0] == 0
    _, err = shot.communicate(timeout=WAIT_S)
    assert shot.returncode != 0
    assert "given up" in err
    shot = rig.start(*SHOT)
    until(lambda: rig.waits_for() == "recording", WAIT_S)
    assert rig.command("film", "--gives-up")[0] == 0
    shot.communicate(timeout=WAIT_S)
