"""How long fit, ranking and verdict take on one core, compiled functions read from disk.

Hard spheres, and contacts that last as those of the simulated rig do.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import numpy as np

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.contact.lasting_contact import EFFECT
from analysis.model.fitting.adding import added
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.rank.ranking import rank
from analysis.model.verdict.selection import explain
from benchmarks.discovery.campaigns import campaign
from benchmarks.discovery.goals import Goal, report
from benchmarks.discovery.lasting import HIDDEN as ON_TOP
from benchmarks.discovery.lasting import PLAIN, lasting_campaign
from benchmarks.discovery.options import Options

HIDDEN = {"image-scale": 0.001}
USUAL, MANY, TIMES = 120, 1000, 10
REPEATS = 5


def run(options: Options) -> None:
    """Measure in this process; the best of several runs, as others may share the core."""
    data, much = campaign(HIDDEN, 3, USUAL), campaign(HIDDEN, 3, MANY)
    more = campaign(HIDDEN, 3, TIMES * USUAL)
    explain(campaign(HIDDEN, 4, 12), CATALOGUE)
    once = _best(lambda: rank(data, fit_campaign(data), CATALOGUE))
    verdict = _best(lambda: explain(data, CATALOGUE))
    many = _best(lambda: rank(much, fit_campaign(much), CATALOGUE))
    tenfold = _best(lambda: rank(more, fit_campaign(more), CATALOGUE))
    goals = [
        _time("fit and rank, 120 shots of 24 frames, s", 0.2, once),
        _time("verdict, 120 shots of 24 frames, s", 2.0, verdict),
        _time("fit and rank, 1000 shots, s", 2.0, many),
        _time("fit and rank, 1200 shots over 120", 11.0, tenfold / min(once)),
    ]
    report("speed", [*goals, *_lasting()], [])


def run_lasting(options: Options) -> None:
    """Measure contacts that last without an effect on top of them."""
    report("speed-lasting", _lasting_alone(), [])


def _lasting_alone() -> list[Goal]:
    data = lasting_campaign(PLAIN, 800, USUAL)
    explain(lasting_campaign(PLAIN, 801, 12), CATALOGUE)

    def fitted() -> Fit:
        return added(data, fit_campaign(data), EFFECT)[1]

    return [
        _time("lasting contact: fit, 120 shots, s", 0.3, _best(fitted)),
        _time("fit and rank, s", 0.5, _best(lambda: rank(data, fitted(), CATALOGUE))),
        _time("verdict, s", 5.0, _best(lambda: explain(data, CATALOGUE), 2)),
    ]


def _lasting() -> list[Goal]:
    """Measure contacts that last: one law alone, and with an effect on top of it."""
    goals = _lasting_alone()
    for name, nature in ON_TOP.items():
        more = lasting_campaign(nature, 900, USUAL)
        seconds = _best(partial(explain, more, CATALOGUE), 1)
        goals.append(_time(f"verdict with {name} on top, s", 5.0, seconds))
    return goals


def _best(work: Callable[[], object], repeats: int = REPEATS) -> np.ndarray:
    """Return processor times of several runs, s."""
    seconds = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return np.array(seconds)


def _time(text: str, asked: float, seconds: np.ndarray) -> Goal:
    return Goal(text, asked, float(seconds.min()), float(seconds.std()), len(seconds), False)
