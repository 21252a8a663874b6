"""How many balls of drawn and real pictures are found: python -m benchmarks.balls.finding.

Drawn pictures (`clutter`) of each kind beside what is drawn in them; real pictures beside how many
balls a person counts (`--real FOLDER`, with the pictures of shared/data/real-images).
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

from analysis.balls.discs.disc import Disc
from analysis.balls.discs.finding import find_balls
from benchmarks.balls.clutter import KINDS, Seen, picture

NEAR, ALIKE = 0.25, 0.2
"""In radii: a found disc is a ball's whose centre and radius differ by less."""
LEAST_RADIUS_PX = 6.0
MOST_SHARE = 0.35
COUNTED = {"coins.png": 24, "bf_0000.png": 5, "bf_0010.png": 5, "bf_0020.png": 5, "bf_0030.png": 5}
LEAST_OUTLINE = 0.35
"""A ball of which less shows, as another's cover hides it, counts neither as there nor as false."""
GOAL_FOUND, GOAL_FALSE = 0.95, 0.1


@dataclass(slots=True)
class Tally:
    """Balls there and found, false discs, pictures, pulls and seconds."""

    there: int = 0
    found: int = 0
    false: int = 0
    pictures: int = 0
    errors: list[float] = field(default_factory=list)
    pulls: list[float] = field(default_factory=list)
    seconds: float = 0.0

    def told(self) -> str:
        pulls = f", off by {np.sqrt(np.mean(np.square(self.errors))):.2f} px rms" * bool(
            self.errors
        )
        if self.pulls:
            pulls += f", pull {np.sqrt(np.mean(np.square(self.pulls))):.2f} rms"
        return (
            f"{self.found} of {self.there} found ({self.found / max(1, self.there):.0%}), "
            f"{self.false} false in {self.pictures} pictures{pulls}, "
            f"{self.seconds / max(1, self.pictures):.2f} s a picture"
        )

    def add(self, other: Tally) -> None:
        """Take in another's counts."""
        self.there, self.found = self.there + other.there, self.found + other.found
        self.false, self.pictures = self.false + other.false, self.pictures + other.pictures
        self.errors += other.errors
        self.pulls += other.pulls
        self.seconds += other.seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--pictures", type=int, default=5)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kinds", nargs="*", default=list(KINDS))
    parser.add_argument("--real", type=Path, help="folder of real pictures")
    parser.add_argument("--keep", type=Path, help="folder for pictures with what was found")
    asked = parser.parse_args()
    if asked.keep is not None:
        asked.keep.mkdir(parents=True, exist_ok=True)
    whole = Tally()
    for name in asked.kinds:
        tally = Tally()
        for seed in range(asked.first, asked.first + asked.pictures):
            shown, balls = picture(KINDS[name], seed)
            discs = _sought(shown, tally)
            _judge(discs, balls, tally)
            if asked.keep is not None:
                _draw(asked.keep / f"{name.replace(' ', '')}-{seed}.png", shown, discs, balls)
        print(f"{name}: {tally.told()}", flush=True)
        whole.add(tally)
    print(f"== drawn: {whole.told()} (goal {GOAL_FOUND:.0%}, {GOAL_FALSE} a picture)")
    if asked.real is not None:
        _real(asked.real)


def _sought(shown: np.ndarray, tally: Tally) -> list[Disc]:
    begun = time.perf_counter()
    found = find_balls(shown, (LEAST_RADIUS_PX, MOST_SHARE * min(shown.shape[:2])))
    tally.seconds += time.perf_counter() - begun
    tally.pictures += 1
    return found


def _judge(discs: list[Disc], balls: list[Seen], tally: Tally) -> None:
    shown = [ball for ball in balls if ball.outline >= LEAST_OUTLINE]
    hidden = [ball for ball in balls if ball.outline < LEAST_OUTLINE]
    rest = [disc for disc in discs if not any(_is(disc, ball) for ball in hidden)]
    tally.there += len(shown)
    for ball in shown:
        own = [disc for disc in rest if _is(disc, ball)]
        if not own:
            continue
        best = min(own, key=lambda d: np.hypot(d.row - ball.row, d.column - ball.column))
        rest.remove(best)
        tally.found += 1
        tally.errors += [best.row - ball.row, best.column - ball.column]
        tally.pulls += [
            (best.row - ball.row) / best.row_sigma,
            (best.column - ball.column) / best.column_sigma,
        ]
    tally.false += len(rest)


def _is(disc: Disc, ball: Seen) -> bool:
    apart = np.hypot(disc.row - ball.row, disc.column - ball.column)
    return bool(apart < NEAR * ball.radius and abs(disc.radius / ball.radius - 1) < ALIKE)


def _draw(path: Path, shown: np.ndarray, discs: list[Disc], balls: list[Seen]) -> None:
    drawn = shown.copy()
    for ball in balls:
        middle = (round(ball.column), round(ball.row))
        cv2.circle(drawn, middle, round(ball.radius), (0, 255, 255), 1)
    for disc in discs:
        middle = (round(disc.column), round(disc.row))
        cv2.circle(drawn, middle, round(disc.radius), (0, 0, 255), 2)
    cv2.imwrite(str(path), drawn)


def _real(folder: Path) -> None:
    """Count what is found in real pictures; more discs than balls are false ones."""
    for path in sorted(folder.rglob("*.png")):
        if path.name not in COUNTED:
            continue
        tally = Tally(there=COUNTED[path.name])
        shown = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        assert shown is not None
        discs = _sought(np.atleast_3d(shown), tally)
        tally.found = min(len(discs), tally.there)
        tally.false = len(discs) - tally.found
        print(f"{path.name}: {tally.told()}", flush=True)


if __name__ == "__main__":
    main()
