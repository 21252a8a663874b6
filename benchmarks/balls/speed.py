"""Frames a second from a film's file to flights: python -m benchmarks.balls.speed.

A film of 1920 x 1080 pixels in colour shows one ball of 60 px that falls and bounces; `--film FILE
MM` adds films of yours with the ball's diameter. Functions are compiled before the clock starts.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np

from analysis.balls.analysis import FilmJob, analyse_film
from analysis.balls.flight.known import Ball
from analysis.balls.measuring import coefficient

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


def measure(path: Path, ball: Ball) -> str:
    """Say how fast a film is measured, and how well its places fit free flights."""
    begun, spent = time.perf_counter(), time.process_time()
    found = analyse_film(FilmJob(1, path, ball))
    seconds, processor = time.perf_counter() - begun, time.process_time() - spent
    head, flights = found.film.head, found.measured.flights
    said = (
        f"{path.name}, {head.width} x {head.height}: {head.frames / seconds:.1f} frames/s, "
        f"{head.frames / processor:.1f} a second of processor time (goal {GOAL:.0f})"
    )
    if flights is None:
        return f"{said}; no bounces"
    rms = np.sqrt((flights.residuals[flights.used] ** 2).mean(axis=0))
    told = [coefficient(found.measured, bounce) for bounce in range(flights.bounces)]
    values = " ".join(f"{e:.4f}({sigma:.4f})" for e, sigma in told)
    return f"{said}; e {values}; places off flights by {rms[0]:.2f}, {rms[1]:.2f} px rms"


def decoded(path: Path) -> str:
    """Say how fast a film's pictures alone are read, once."""
    spent, video, frames = time.process_time(), cv2.VideoCapture(str(path)), 0
    while video.read()[0]:
        frames += 1
    return f"decoding alone: {frames / (time.process_time() - spent):.0f} frames a second of it"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument(
        "--film",
        nargs=2,
        action="append",
        default=[],
        metavar=("FILE", "MM"),
        help="a film of yours and its ball's diameter, after the drawn one",
    )
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        films = {frames: Path(folder) / f"{frames}.mp4" for frames in (SHORT, FRAMES)}
        for frames, path in films.items():
            draw(path, frames)
        ball = Ball(2 * RADIUS / FALL * 9.80665)
        analyse_film(FilmJob(1, films[SHORT], ball))
        print(measure(films[FRAMES], ball), flush=True)
        print(decoded(films[FRAMES]), flush=True)
    for name, millimetres in asked.film:
        print(measure(Path(name), Ball(1e-3 * float(millimetres))), flush=True)


if __name__ == "__main__":
    main()
