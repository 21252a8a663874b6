"""Two effects are hidden together: are both found, and nothing beside them."""

from __future__ import annotations

import numpy as np

from benchmarks.discovery.goals import report, share, show
from benchmarks.discovery.options import Options
from benchmarks.discovery.power import EFFECTS
from benchmarks.discovery.trial import Task, Trial, judged
from simulators.challenge.effects import HIDDEN

FIRST_SEED = 300_000
WEAKEST, STRONGEST = 6.0, 8.0


def run(options: Options) -> None:
    trials = judged([_task(options, k) for k in range(options.campaigns)], options.processes)
    show(t for t in trials if not _right(t) or len(t.effects) > 2 or t.word == "unexplained")
    right = [_right(trial) for trial in trials]
    third = [len(trial.effects) > 2 for trial in trials]
    alarmed = [trial.word == "unexplained" for trial in trials]
    report(
        "pairs",
        [
            share("both of two effects at d = 6 to 8 named, or their like", 0.90, right),
            share("a third effect beside them", 0.07, third, at_least=False),
            share("called unexplained", 0.05, alarmed, at_least=False),
        ],
        trials,
    )


def _task(options: Options, k: int) -> Task:
    rng = np.random.default_rng(FIRST_SEED + k)
    first = str(rng.choice(EFFECTS))
    others = [n for n in EFFECTS if HIDDEN[n].acts_on != HIDDEN[first].acts_on]
    wanted = {n: rng.uniform(WEAKEST, STRONGEST) for n in (first, str(rng.choice(others)))}
    return Task(seed=FIRST_SEED + k, shots=options.shots, wanted=wanted)


def _right(trial: Trial) -> bool:
    """Whether each hidden effect is named, itself or by one of its like."""
    return all(
        bool({name, *HIDDEN[name].like, *HIDDEN[name].beside} & trial.named)
        for name in trial.amplitudes
    )
