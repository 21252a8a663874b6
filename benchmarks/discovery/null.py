"""Nothing is missing: how often something is claimed all the same."""

from __future__ import annotations

from benchmarks.discovery.goals import report, share, show
from benchmarks.discovery.options import Options
from benchmarks.discovery.trial import Task, judged

FIRST_SEED = 100_000
TREATED = ("bad shots", "as stated", "wrong sigmas")


def run(options: Options) -> None:
    tasks = [
        Task(seed=FIRST_SEED + k, shots=options.shots, treatment=treatment)
        for treatment in TREATED
        for k in range(options.campaigns)
    ]
    trials = judged(tasks, options.processes)
    show(trial for trial in trials if trial.word != "none")
    goals = []
    for treatment in TREATED:
        own = [trial for trial in trials if trial.task.treatment == treatment]
        claimed, alarmed = [t.claimed for t in own], [t.word == "unexplained" for t in own]
        goals.append(share(f"{treatment}: an effect claimed", 0.05, claimed, at_least=False))
        goals.append(share(f"{treatment}: unexplained", 0.01, alarmed, at_least=False))
    report("null", goals, trials)
