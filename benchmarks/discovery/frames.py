"""Campaigns as frames: rendered, measured by the photometric method, then explained."""

from __future__ import annotations

from benchmarks.discovery.goals import report, share, show
from benchmarks.discovery.options import Options
from benchmarks.discovery.outside import OUTSIDE
from benchmarks.discovery.power import EFFECTS
from benchmarks.discovery.trial import Task, Trial, judged
from simulators.challenge.effects import HIDDEN

FIRST_SEED = 700_000
WEAKEST = 6.0
SHARES = (1.0, 0.25)


def run(options: Options) -> None:
    """Hide nothing, and one effect after the other, known or not, at full and quarter strength."""
    names = (None, *EFFECTS, *OUTSIDE)
    tasks = [
        Task(
            seed=FIRST_SEED + k,
            shots=options.shots,
            amplitudes=_hidden(names[k % len(names)], SHARES[k // len(names) % len(SHARES)]),
            filmed=True,
        )
        for k in range(options.campaigns)
    ]
    trials = judged(tasks, options.processes)
    show(trial for trial in trials if not _right(trial))
    strong = [t for t in trials if t.strength >= WEAKEST]
    quiet = [t for t in trials if not t.amplitudes]
    report(
        "frames",
        [
            share("from frames, d >= 6: right", 0.98, [_right(t) for t in strong]),
            share(
                "from frames, nothing missing: something claimed",
                0.05,
                [t.word != "none" for t in quiet],
                at_least=False,
            ),
        ],
        trials,
    )


def _hidden(name: str | None, part: float) -> dict[str, float]:
    return {} if name is None else {name: part * HIDDEN[name].amplitude}


def _right(trial: Trial) -> bool:
    """Whether the verdict is the truth: its name and no other, or that none has one."""
    if not trial.amplitudes:
        return trial.word == "none"
    [name] = trial.amplitudes
    if not HIDDEN[name].known:
        return trial.word == "unexplained"
    return trial.claimed and trial.holds(name) and len(trial.effects) == 1
