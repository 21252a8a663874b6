"""How much of the error on shots left out goes with what is found."""

from __future__ import annotations

import numpy as np

from benchmarks.discovery.goals import Goal, report, show
from benchmarks.discovery.options import Options
from benchmarks.discovery.power import EFFECTS
from benchmarks.discovery.trial import Task, Trial, judged

FIRST_SEED = 500_000
WEAKEST, STRONGEST = 6.0, 12.0
ASKED = 0.94


def run(options: Options) -> None:
    steps = np.linspace(WEAKEST, STRONGEST, options.campaigns)
    tasks = [
        Task(
            seed=FIRST_SEED + k,
            shots=options.shots,
            wanted={EFFECTS[k % len(EFFECTS)]: float(d)},
            with_floor=True,
        )
        for k, d in enumerate(steps)
    ]
    trials = judged(tasks, options.processes)
    shares = np.array([removed(trial) for trial in trials])
    show(trial for trial, share in zip(trials, shares, strict=True) if share < 0.5)
    error = 1.2533 * float(shares.std()) / float(np.sqrt(len(shares)))
    median = float(np.median(shares))
    report(
        "removed",
        [
            Goal(
                "median share of the removable error removed, d >= 6",
                ASKED,
                median,
                error,
                len(shares),
            )
        ],
        trials,
    )


def removed(trial: Trial) -> float:
    """Return the share of E_cv above that of the same campaign with nothing hidden."""
    removable = trial.errors[0] - trial.floor
    return (trial.errors[0] - trial.errors[-1]) / removable
