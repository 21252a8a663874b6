"""One effect is hidden, the whole catalogue is looked at: is it found, and rightly named."""

from __future__ import annotations

from collections.abc import Iterable

from benchmarks.discovery.goals import Goal, report, share, show
from benchmarks.discovery.options import Options
from benchmarks.discovery.strength import believable_shots
from benchmarks.discovery.trial import Task, Trial, judged
from simulators.challenge.effects import HIDDEN

FIRST_SEED = 200_000
ASKED = {4.0: 0.75, 5.0: 0.95, 6.0: 0.99}
COMPOUND = ("wind",)
"""What comes with another effect, so that its own d is not that of the campaign."""
FEW_SHOTS = ("tangential-compliance",)
"""What, this weak, shows in the one or two shots between rolling and sliding: no finding that two
shots carry is believed."""
EFFECTS = tuple(
    name for name, h in HIDDEN.items() if h.known and name not in (*COMPOUND, *FEW_SHOTS)
)
NESTED = ("drag",)
"""Contained in an effect that looks like it: the likelihood ratio decides between the two."""


def run(options: Options) -> None:
    tasks = [
        Task(
            seed=(seed := FIRST_SEED + 1000 * n + k),
            shots=believable_shots(name, d, seed, options.shots),
            wanted={name: d},
        )
        for n, d in enumerate(ASKED)
        for k, name in zip(range(options.campaigns), _in_turn(), strict=False)
    ]
    trials = judged(tasks, options.processes)
    found = [trial for trial in trials if trial.word != "none"]
    show(t for t in trials if t.word == "none" or not t.holds(hidden(t)) or len(t.effects) != 1)
    goals = []
    for d, asked in ASKED.items():
        own = [t.word != "none" for t in trials if d in t.task.wanted.values()]
        goals.append(share(f"detected at d = {d:.0f}", asked, own))
    goals.append(share("right one named or in the alias set, of detections", 0.98, _right(found)))
    goals += _pairs(found)
    report("power", goals, trials)


def hidden(trial: Trial) -> str:
    [name] = trial.amplitudes
    return name


def _in_turn() -> Iterable[str]:
    while True:
        yield from EFFECTS


def _right(trials: Iterable[Trial]) -> list[bool]:
    return [trial.holds(hidden(trial)) for trial in trials]


def _pairs(found: list[Trial]) -> list[Goal]:
    """Return how often one name alone is given where others look the same to such shots."""
    doubtful = [t for t in found if HIDDEN[hidden(t)].like and hidden(t) not in NESTED]
    alone = [trial.word == "effect" for trial in doubtful]
    return [share("an indistinguishable pair given one name", 0.10, alone, at_least=False)]
