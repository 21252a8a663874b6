"""Places of a blotched ball that only turns: python -m benchmarks.balls.turning.

Films of 300 frames on a cluttered ground, the ball's lower part in a holder, as they come from a
camera and through a codec. The ball's centre stands still: the scatter of the places that
`rigctl analyse` gives is all error.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.balls.analysis import FilmJob, analyse_film
from analysis.balls.carried import NotFlyingError
from analysis.balls.flight.known import Ball
from analysis.balls.seen.placing import Placed
from analysis.errors import ShotRefusedError
from benchmarks.balls.clutter import Drawn, Seen, ground, stage, traced

KINDS = ("plain", "compressed")
FRAMES, RATE_HZ = 300, 60.0
GOAL_PX = 0.1
NOISE = 2.0
SIZE = (288, 384)
DIAMETER_M = 0.05


def draw(path: Path, kind: str, seed: int, frames: int = FRAMES) -> Seen:
    """Draw a film of a ball that turns about once, and return where it is.

    Parameters
    ----------
    path
        A folder of PNG files for a plain film, a .mp4 file for a compressed one.
    """
    rng = np.random.default_rng([KINDS.index(kind), seed])
    flat = ground(rng, SIZE)
    tone = rng.uniform(0.75, 1.0) if flat.mean() < 0.4 else rng.uniform(0.2, 0.3)
    row, column, radius = rng.uniform((110, 150, 28), (150, 230, 50)).tolist()
    ball = Seen(row, column, radius)
    scene = replace(stage(rng, 0.6, tone * rng.uniform(0.6, 1.0, 3)), blotches=0.3)
    turns = rng.uniform(0.0, 6.0) + rng.uniform(4.0, 8.0) * np.arange(frames) / frames
    holder, edge = rng.uniform(0.0, 0.7, 3), round(ball.row + rng.uniform(0.3, 0.8) * ball.radius)
    blur = float(rng.uniform(0.5, 1.0))
    video = None
    if kind == "compressed":
        code = cv2.VideoWriter.fourcc(*"mp4v")
        video = cv2.VideoWriter(str(path), code, RATE_HZ, SIZE[::-1])
    else:
        path.mkdir(parents=True, exist_ok=True)
    for k, turn in enumerate(turns.tolist()):
        own, cover = traced(replace(scene, turn=turn), ball, (0.0, 0.0), 1000 * seed + k)
        rows, columns = SIZE
        light = flat * (1 - cover[:rows, :columns]) + own[:rows, :columns]
        left, right = round(ball.column - 20), round(ball.column + 20)
        light[edge:, left:right] = holder
        shown = _digitised(light, blur, rng)
        if video is not None:
            video.write(shown)
        else:
            cv2.imwrite(str(path / f"{k:04d}.png"), shown[..., 1])
    if video is not None:
        video.release()
    return ball


def _digitised(light: NDArray[np.float64], blur: float, rng: np.random.Generator) -> Drawn:
    blurred = cv2.GaussianBlur(np.maximum(light, 0.0), (0, 0), blur)
    noisy = 230 * np.asarray(blurred) + NOISE * rng.standard_normal(light.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def places(path: Path) -> tuple[Placed | None, str]:
    """Return the places that a film's analysis gives, and why it is refused."""
    try:
        found = analyse_film(FilmJob(1, path, Ball(DIAMETER_M), RATE_HZ))
    except NotFlyingError as refusal:
        return refusal.placed, refusal.reason
    except ShotRefusedError as refusal:
        return None, refusal.reason
    return found.measured.placed, "not refused"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--films", type=int, default=3)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kinds", nargs="*", default=list(KINDS))
    asked = parser.parse_args()
    for kind in asked.kinds:
        for seed in range(asked.first, asked.first + asked.films):
            with tempfile.TemporaryDirectory() as home:
                path = Path(home) / ("film.mp4" if kind == "compressed" else "film")
                drawn = draw(path, kind, seed)
                begun = time.perf_counter()
                placed, why = places(path)
                seconds = time.perf_counter() - begun
            print(f"{kind} {seed}: {_told(placed, drawn)}, {seconds:.1f} s; {why}", flush=True)


def _told(placed: Placed | None, drawn: Seen) -> str:
    if placed is None:
        return "no places"
    off = placed.places - (drawn.row, drawn.column)
    (row, column), stated = off.std(axis=0), np.median(placed.sigmas, axis=0)
    return (
        f"{len(off)} of {FRAMES} places, scatter {row:.3f}, {column:.3f} px "
        f"(stated {stated[0]:.3f}, {stated[1]:.3f}; goal {GOAL_PX}), all off by "
        f"{off[:, 0].mean():+.3f}, {off[:, 1].mean():+.3f} px, radius {drawn.radius:.1f} px"
    )


if __name__ == "__main__":
    main()
