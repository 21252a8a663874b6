"""Whether a fitted contact is as far from the simulator's as its stated errors say.

Of each parameter of a contact that lasts: the root mean square of its pulls, the error over the
stated one. Poses scatter as they are stated, and the drag of the air is drawn from what is stated
of it. A campaign whose force law is taken for another has the other's parameters and counts apart.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.effects.contact.lasting_contact import EFFECT
from analysis.model.fitting.robust_fit import Judged, judged
from benchmarks.discovery.goals import Goal, report, share
from benchmarks.discovery.lasting import PLAIN, RIG, STATED_DRAG, lasting_campaign
from benchmarks.discovery.options import Options

FIRST_SEED = 600_000
STATED_ERROR = 0.2
LEAST, MOST = 0.8, 1.25
TRUE = {
    "e": PLAIN.restitution,
    "mu": PLAIN.friction,
    "lasting-contact.t": RIG.duration_s,
    "lasting-contact.kappa": RIG.stiffness_ratio,
    "lasting-contact.zeta": RIG.damping_ratio,
}


def run(options: Options) -> None:
    """Print the pulls of each parameter over many campaigns."""
    found = [_judged(FIRST_SEED + k, options.shots) for k in range(options.campaigns)]
    right = [one for one in found if _law(one) == EFFECT.title]
    others = [_law(one) != EFFECT.title for one in found]
    pulls = np.array([_pulls(one) for one in right]).reshape(-1, len(TRUE))
    goals = [share("force law taken for another", 0.05, others, at_least=False)]
    for name, own in zip(TRUE, pulls.T, strict=True):
        size = float(np.sqrt((own**2).mean()))
        error = size / np.sqrt(2 * len(own))
        print(f"  {name:24} mean {own.mean():+.2f}, worst {np.abs(own).max():.1f}")
        goals.append(Goal(f"{name}: pulls, rms", LEAST, size, error, len(own)))
        goals.append(Goal(f"{name}: pulls, rms", MOST, size, error, len(own), at_least=False))
    report("pulls", goals, [])


def _judged(seed: int, shots: int) -> Judged:
    drawn = max(float(np.random.default_rng(seed).normal(STATED_DRAG, STATED_ERROR)), 0.0)
    nature = replace(PLAIN, drag_coefficient=drawn)
    return judged(lasting_campaign(nature, seed, shots), (EFFECT,))


def _law(found: Judged) -> str | None:
    law = found.fit.theory.contact_law
    return None if law is None else law.title


def _pulls(found: Judged) -> list[float]:
    fitted = found.fit.parameters()
    return [(fitted[name].value - true) / fitted[name].sigma for name, true in TRUE.items()]
