"""What is asked beside what was measured."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchmarks.discovery.trial import Trial

OUT = Path("out")


@dataclass(frozen=True, slots=True)
class Goal:
    """A number asked for.

    Attributes
    ----------
    at_least
        Whether more is better.
    error
        Standard error of what was measured.
    """

    text: str
    asked: float
    measured: float
    error: float
    of: int
    at_least: bool = True

    @property
    def kept(self) -> bool:
        return self.measured >= self.asked if self.at_least else self.measured <= self.asked

    def __str__(self) -> str:
        sign = ">=" if self.at_least else "<="
        word = "kept" if self.kept else "MISSED"
        return (
            f"{self.text:<62} {sign} {self.asked:<6.4g} {self.measured:8.4f} "
            f"+- {self.error:.4f} of {self.of:<5d} {word}"
        )


def share(text: str, asked: float, hits: Iterable[bool], *, at_least: bool = True) -> Goal:
    """Return a share with its binomial error, Agresti and Coull's near 0 and 1."""
    seen = list(hits)
    count = len(seen)
    value = sum(seen) / max(count, 1)
    moved = (sum(seen) + 2) / (count + 4)
    error = float(np.sqrt(moved * (1 - moved) / (count + 4)))
    return Goal(text, asked, value, error, count, at_least)


def report(section: str, goals: Sequence[Goal], trials: Sequence[Trial]) -> None:
    """Print goals and write them with every campaign to out/."""
    print(f"\n{section}")
    for goal in goals:
        print(goal)
    OUT.mkdir(exist_ok=True)
    document = {
        "section": section,
        "goals": [{**asdict(goal), "kept": goal.kept} for goal in goals],
        "trials": [asdict(trial) for trial in trials],
    }
    path = OUT / f"discovery-{section}.json"
    path.write_text(json.dumps(document, indent=1, default=dict) + "\n", encoding="utf-8")


def show(trials: Iterable[Trial]) -> None:
    """Print campaigns one by one: those that went wrong."""
    for trial in trials:
        hidden = {name: float(f"{size:.3g}") for name, size in trial.amplitudes.items()}
        errors = " ".join(f"{error:.4f}" for error in trial.errors)
        where = f"{trial.cell[0]} | {trial.cell[1]} {trial.cell[2]:.1f} p {trial.cell[3]:.2g}"
        names = ",".join(trial.effects) or "-"
        company = ",".join(trial.alias_set[1:])
        print(
            f"  {trial.task.treatment} seed {trial.task.seed} {hidden} -> {trial.word}: {names}"
            f" ({company}) E {errors} dropped {trial.dropped} {where}"
        )
