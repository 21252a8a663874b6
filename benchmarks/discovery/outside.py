"""Something is hidden that no catalogue has: is it called unexplained, or by a wrong name.

Strength is lack of fit's own: the root of the chi-squared of the best cell, without noise, after
the one effect of the catalogue that imitates best. An alarm needs it near `THRESHOLD`.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.stats import chi2 as chi2_distribution

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import ScatterEffect
from analysis.model.data.inside import without_contact_frames
from analysis.model.fitting.fit import fit_campaign
from analysis.model.rank.ranking import rank
from analysis.model.structure.alarm import UNEXPLAINED_LEVEL
from analysis.model.structure.channels import SMOOTH
from analysis.model.structure.lackoffit import cells_of
from benchmarks.discovery.campaigns import SILENCE, campaign
from benchmarks.discovery.goals import Goal, report, share, show
from benchmarks.discovery.options import Options
from benchmarks.discovery.trial import Task, Trial, judged
from simulators.challenge.effects import HIDDEN

FIRST_SEED = 600_000
OUTSIDE = tuple(name for name, hidden in HIDDEN.items() if not hidden.known)
ABOVE = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0)
"""Strengths, counted from the threshold."""
ALARMS, ASKED, MOST_WRONG = 2.0, 0.95, 0.10
PROBES, IMITATORS = 2, 5


def run(options: Options) -> None:
    amplitudes = {name: _amplitude_of_unit(name, options.shots) for name in OUTSIDE}
    tasks, levels = [], []
    for k in range(options.campaigns * len(ABOVE)):
        name, above = OUTSIDE[k % len(OUTSIDE)], ABOVE[(k // len(OUTSIDE)) % len(ABOVE)]
        cells = len(OUTSIDE) * len(ABOVE)
        amplitude = (threshold() + above) * amplitudes[name] * (-1.0) ** (k // cells)
        tasks.append(Task(seed=FIRST_SEED + k, shots=options.shots, amplitudes={name: amplitude}))
        levels.append(above)
    trials = judged(tasks, options.processes)
    show(trial for trial in trials if trial.claimed)
    goals = []
    for above in ABOVE:
        own = [trial for trial, level in zip(trials, levels, strict=True) if level == above]
        goals += _goals(above, own)
    report("outside", goals, trials)


def _goals(above: float, trials: list[Trial]) -> list[Goal]:
    """Return what is asked at one strength; an alias set of wrong names is counted by itself."""
    found = {
        "unexplained": [trial.word == "unexplained" for trial in trials],
        "one wrong name": [trial.word == "effect" for trial in trials],
        "one of several wrong names": [trial.word == "alias" for trial in trials],
    }
    asked = {"unexplained": ASKED if above >= ALARMS else 0.0}
    return [
        share(
            f"own d at threshold {above:+.0f}: {text}",
            asked.get(text, MOST_WRONG),
            hits,
            at_least=text in asked,
        )
        for text, hits in found.items()
    ]


def threshold() -> float:
    """Return the own d at which the best cell alarms about every other time."""
    # 12 channels against 12 covariates, 12 against time and 9 in the field, Holm's first step.
    cells = 12 * 12 + 12 + 9
    return float(np.sqrt(chi2_distribution.isf(UNEXPLAINED_LEVEL / cells, SMOOTH) - SMOOTH))


def _amplitude_of_unit(name: str, shots: int) -> float:
    """Return the size at which lack of fit's own d is 1, from its size at a twentieth of full."""
    size = HIDDEN[name].amplitude / 20
    own = [own_strength({name: size}, FIRST_SEED + k, shots) for k in range(PROBES)]
    return size / float(np.mean(own))


def own_strength(amplitudes: Mapping[str, float], seed: int, shots: int) -> float:
    """Return lack of fit's own d."""
    silent = without_contact_frames(campaign(amplitudes, seed, shots, noise=SILENCE))
    base = fit_campaign(silent)
    shifts = [effect for effect in CATALOGUE if not isinstance(effect, ScatterEffect)]
    first = rank(silent, base, shifts).candidates[:IMITATORS]
    fits = [fit_campaign(silent, base.theory.with_effect(c.effect), base) for c in first]
    best = min(fits, key=lambda fit: fit.chi2)
    cells = cells_of(silent, best)
    return float(np.sqrt(max(cell.chi2 for cell in cells) * best.chi2_per_dof))
