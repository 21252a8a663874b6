"""Air on top of contacts that last: as it is stated, within its error, and three times as large."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.effects.catalogue import CATALOGUE
from analysis.model.verdict.selection import Verdict, explain
from benchmarks.discovery.goals import report, share
from benchmarks.discovery.lasting import AIR, PLAIN, STATED_DRAG, lasting_campaign
from benchmarks.discovery.options import Options
from simulators.challenge.nature import Nature

FIRST_SEED = 500_000
STATED_ERROR = 0.2
LAW = "lasting-contact"


def run(options: Options) -> None:
    """Print how often air as stated is given a name, and air three times as large is not."""
    seeds = [FIRST_SEED + k for k in range(options.campaigns)]
    quiet = [_verdict("as stated", _as_stated(seed), seed, options.shots) for seed in seeds]
    strong = replace(PLAIN, drag_coefficient=3 * AIR)
    loud = [_verdict("three times", strong, seed, options.shots) for seed in seeds]
    goals = [
        share("air as stated: something claimed", 0.05, map(_claims, quiet), at_least=False),
        share("air as stated: unexplained", 0.01, map(_alarms, quiet), at_least=False),
        share("air three times as large: named", 0.9, map(_names, loud)),
        share("air three times as large: more named", 0.05, map(_more, loud), at_least=False),
    ]
    report("air", goals, [])


def _as_stated(seed: int) -> Nature:
    """Return a world whose drag is drawn from what is stated of it."""
    drawn = np.random.default_rng(seed).normal(STATED_DRAG, STATED_ERROR)
    return replace(PLAIN, drag_coefficient=max(float(drawn), 0.0))


def _verdict(what: str, nature: Nature, seed: int, shots: int) -> Verdict:
    verdict = explain(lasting_campaign(nature, seed, shots), CATALOGUE)
    if verdict.verdict != "effect" or verdict.effects not in {(LAW,), (LAW, "drag")}:
        print(f"  {what} {seed}: {verdict.verdict} {', '.join(verdict.effects)}", flush=True)
    return verdict


def _claims(verdict: Verdict) -> bool:
    return {*verdict.effects} != {LAW}


def _alarms(verdict: Verdict) -> bool:
    return verdict.verdict == "unexplained"


def _names(verdict: Verdict) -> bool:
    return "drag" in verdict.effects


def _more(verdict: Verdict) -> bool:
    return bool({*verdict.effects} - {LAW, "drag"})
