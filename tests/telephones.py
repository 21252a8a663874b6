"""A rig whose camera is a telephone, and the film of a ball that falls on a plate."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

PLATE = Path(__file__).parents[1] / "config" / "simulated-plate.toml"
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


def configure(folder: Path) -> Path:
    """Write the simulated plate with that camera; return the file."""
    plate = PLATE.read_text(encoding="utf-8")
    begin, end = plate.index("[camera]"), plate.index("[store]")
    text = plate[:begin] + CAMERA + plate[end:]
    text = text.replace("front_view_rows = [0, 192]", "front_view_rows = [0, 360]")
    (folder / "rig.toml").write_text(text.replace("[96.0, 120.0]", "[180.0, 80.0]"))
    return folder / "rig.toml"
