"""How many balls of photographs are found: python -m benchmarks.balls.photographs FOLDER.

FOLDER holds pictures and `labels.csv`, with the columns picture, row, column, radius (pixels, as a
person sees them) and kind:

- ball: a ball that a person clearly sees.
- round: what counts neither way, as another sphere, a coin, a wheel, a printed disc, or a ball of
  which a person sees little.
- many: the picture has more of what is round than is listed: a disc that is none of its balls
  counts neither way. Row, column and radius are not read.
- none: the picture has nothing to list. Row, column and radius are not read.

A found disc that is none of those listed is a false one. `--half odd` takes each second picture, in
alphabetical order, and `--half even` the others, for choices by one half that the other one tests.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import time
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

from analysis.balls.discs.disc import Disc
from analysis.balls.discs.finding import find_balls
from benchmarks.balls.finding import GOAL_FALSE, GOAL_FOUND, LEAST_RADIUS_PX, MOST_SHARE

NEAR, ALIKE, BY_HAND_PX = 0.3, 0.25, 1.5
"""In radii: a found disc is a labelled one whose centre and radius differ by less, or by less than
a label by hand is off."""
RADII_PX = (0.0, 10.0, 20.0, 40.0, np.inf)


@dataclass(frozen=True, slots=True)
class Label:
    """A circle that a person sees, pixels."""

    row: float
    column: float
    radius: float
    kind: str

    def fits(self, disc: Disc) -> bool:
        """Return whether a found disc is this one."""
        apart = np.hypot(disc.row - self.row, disc.column - self.column)
        return bool(
            apart < max(BY_HAND_PX, NEAR * self.radius)
            and abs(disc.radius - self.radius) < max(BY_HAND_PX, ALIKE * self.radius)
        )


@dataclass(slots=True)
class Counts:
    """Radii of balls seen, of those found and of false discs; pictures, processor seconds."""

    seen: list[float] = field(default_factory=list)
    found: list[float] = field(default_factory=list)
    false: list[float] = field(default_factory=list)
    pictures: int = 0
    seconds: float = 0.0

    def told(self) -> str:
        """Return found of seen balls and false discs of a picture, in all and by radius."""
        whole = self._between(0.0, np.inf)
        parts = [
            f"  {low:g} to {high:g} px: {self._between(low, high)}"
            for low, high in itertools.pairwise(RADII_PX)
        ]
        spent = f"{self.seconds / max(1, self.pictures):.2f} s of the processor a picture"
        goal = f"(goal {GOAL_FOUND:.0%}, {GOAL_FALSE} a picture)"
        return "\n".join([f"{whole}, {self.pictures} pictures, {spent} {goal}", *parts])

    def _between(self, low: float, high: float) -> str:
        seen, found, false = (
            sum(low <= radius < high for radius in radii)
            for radii in (self.seen, self.found, self.false)
        )
        share = f" ({found / seen:.0%})" if seen else ""
        return (
            f"{found} of {seen} found{share}, {false} false, "
            f"{false / max(1, self.pictures):.2f} a picture"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--half", choices=("odd", "even"))
    asked = parser.parse_args()
    labels = read_labels(asked.folder / "labels.csv")
    names = sorted(labels)
    if asked.half is not None:
        names = names[asked.half == "even" :: 2]
    counts = Counts()
    for name in names:
        shown = cv2.imread(str(asked.folder / name), cv2.IMREAD_UNCHANGED)
        if shown is None:
            raise SystemExit(f"{name} cannot be read: labels.csv names it")
        begun = time.process_time()
        found = find_balls(shown, (LEAST_RADIUS_PX, MOST_SHARE * min(shown.shape[:2])))
        counts.seconds += time.process_time() - begun
        lost, false = judge(found, labels[name], counts)
        told = [f"lost {_place(each)}" for each in lost] + [f"false {_place(d)}" for d in false]
        if told:
            print(f"{name}: {'; '.join(told)}", flush=True)
    print(counts.told())


def read_labels(path: Path) -> dict[str, list[Label]]:
    """Return the labels of each picture."""
    labels: dict[str, list[Label]] = {}
    with path.open(encoding="utf-8", newline="") as rows:
        for row in csv.DictReader(rows):
            line, column, radius = (float(row[name]) for name in ("row", "column", "radius"))
            labels.setdefault(row["picture"], []).append(Label(line, column, radius, row["kind"]))
    return labels


def judge(found: list[Disc], labels: list[Label], counts: Counts) -> tuple[list[Label], list[Disc]]:
    """Add what is found of a picture to the counts; return balls that are lost and false discs."""
    rest, lost = list(found), []
    for ball in (each for each in labels if each.kind == "ball"):
        own = [disc for disc in rest if ball.fits(disc)]
        counts.seen.append(ball.radius)
        if own:
            rest.remove(own[0])
            counts.found.append(ball.radius)
        else:
            lost.append(ball)
    many = any(each.kind == "many" for each in labels)
    listed = [each for each in labels if each.kind == "round"]
    false = [disc for disc in rest if not many and not any(each.fits(disc) for each in listed)]
    counts.false += [disc.radius for disc in false]
    counts.pictures += 1
    return lost, false


def _place(circle: Label | Disc) -> str:
    return f"({circle.row:.0f}, {circle.column:.0f}) r {circle.radius:.0f}"


if __name__ == "__main__":
    main()
