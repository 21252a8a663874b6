"""Frames a second from a film's file to flights: python -m benchmarks.balls.speed.

A film of 1920 x 1080 pixels in colour shows one ball of 60 px that falls and bounces. Functions are
compiled before the clock starts.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import cv2
import numpy as np

from analysis.balls.analysis import FilmJob, analyse_film
from analysis.balls.flight.known import Ball

ROWS, COLUMNS, RADIUS, RATE, FALL = 1080, 1920, 30.0, 120.0, 4000.0
FRAMES, SHORT = 240, 110
GOAL = 60.0


def draw(path: Path, frames: int) -> None:
    rng = np.random.default_rng(0)
    ground = cv2.GaussianBlur(rng.normal(120.0, 60.0, (ROWS, COLUMNS, 3)), (0, 0), 9.0)
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), RATE, (COLUMNS, ROWS))
    top, plate, begun, speed = 150.0, 950.0, 0.0, 0.0
    contact = (2 * (plate - top) / FALL) ** 0.5
    for k in range(frames):
        t = k / RATE
        while t > contact:
            arrives = speed if begun else FALL * contact
            begun, speed = contact, 0.8 * arrives
            contact = begun + 2 * speed / FALL
        gone = t - begun
        row = plate - speed * gone if begun else top
        picture = np.asarray(ground).astype(np.uint8)
        place = (round(16 * (900 + 40 * t)), round(16 * (row + 0.5 * FALL * gone**2)))
        cv2.circle(picture, place, round(16 * RADIUS), (40, 90, 230), -1, cv2.LINE_AA, 4)
        video.write(picture)
    video.release()


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        films = {frames: Path(folder) / f"{frames}.mp4" for frames in (SHORT, FRAMES)}
        for frames, path in films.items():
            draw(path, frames)
        ball = Ball(2 * RADIUS / FALL * 9.80665)
        analyse_film(FilmJob(1, films[SHORT], ball))
        begun, spent = time.perf_counter(), time.process_time()
        found = analyse_film(FilmJob(1, films[FRAMES], ball))
        seconds, processor = time.perf_counter() - begun, time.process_time() - spent
        bounces = 0 if found.measured.flights is None else found.measured.flights.bounces
        print(
            f"{COLUMNS} x {ROWS}: {FRAMES / seconds:.1f} frames/s, {FRAMES / processor:.1f} a "
            f"second of processor time (goal {GOAL:.0f}), {bounces} bounces"
        )


if __name__ == "__main__":
    main()
