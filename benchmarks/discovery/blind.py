"""Little to go by: no orientations, one setting, five shots. Right or silent, never wrong."""

from __future__ import annotations

from benchmarks.discovery.goals import report, share, show
from benchmarks.discovery.options import Options
from benchmarks.discovery.power import EFFECTS, FEW_SHOTS
from benchmarks.discovery.trial import Task, Trial, judged
from simulators.challenge.effects import HIDDEN

FIRST_SEED = 400_000
FEW = 5


def run(options: Options) -> None:
    tasks = [
        Task(
            seed=FIRST_SEED + k,
            shots=FEW if poor == "five shots" else options.shots,
            amplitudes=_hidden(k),
            treatment="no orientations" if poor == "no orientations" else "as stated",
            one_setting=poor == "one setting",
        )
        for poor in ("no orientations", "one setting", "five shots")
        for k in range(options.campaigns)
    ]
    trials = judged(tasks, options.processes)
    show(trial for trial in trials if _wrong(trial))
    goals = []
    for n, poor in enumerate(("no orientations", "one setting", "five shots")):
        own = trials[n * options.campaigns : (n + 1) * options.campaigns]
        wrong = [_wrong(trial) for trial in own]
        right = [not _wrong(trial) and trial.word != "none" for trial in own]
        goals.append(share(f"{poor}: wrong", 0.0, wrong, at_least=False))
        goals.append(share(f"{poor}: right, not silent", 0.0, right))
    report("blind", goals, trials)


def _hidden(k: int) -> dict[str, float]:
    """Return one effect after the other at full strength, and nothing once a round."""
    names = (*EFFECTS, *FEW_SHOTS, None)
    name = names[k % len(names)]
    if name is None:
        return {}
    effect = HIDDEN[name]
    sign = -1.0 if effect.either_sign and (k // len(names)) % 2 else 1.0
    return {name: sign * effect.amplitude}


def _wrong(trial: Trial) -> bool:
    """Whether something is named and the truth is not among it, or not all of it is true."""
    if trial.word == "none":
        return False
    return not trial.amplitudes or not all(trial.holds(name) for name in trial.amplitudes)
