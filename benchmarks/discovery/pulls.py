"""Whether a fitted contact is as far from the simulator's as its stated errors say.

Of each parameter of a contact that lasts: the root mean square of its pulls, the error over the
stated one. Poses scatter as they are stated, and the drag of the air is drawn from what is stated
of it. A campaign whose force law is taken for another has the other's parameters and counts apart.
With --slow-px poses are as exact as filmed ones, and err as is stated of those: slowly as well, and
all alike by scale and outlines.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.effects.contact.lasting_contact import EFFECT
from analysis.model.fitting.robust_fit import Judged, judged
from benchmarks.discovery.filmed_errors import filmed
from benchmarks.discovery.goals import Goal, report, share
from benchmarks.discovery.lasting import PLAIN, RIG, STATED_DRAG, lasting_campaign
from benchmarks.discovery.options import Options
from simulators.challenge.bodies import Bodies
from simulators.challenge.coefficients import Coefficients
from simulators.challenge.forces import press_by
from simulators.challenge.launch import Touch
from simulators.challenge.nature import Nature
from simulators.world.description import Sphere

FIRST_SEED = 600_000
STATED_ERROR = 0.2
LEAST, MOST = 0.8, 1.25


def left_head_on(nature: Nature = PLAIN) -> float:
    """Return what the world's contact, in its steps, leaves of 2 m/s: 2e-5 less than is asked."""
    along, still = np.array([[[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]]), np.zeros((1, 2, 3))
    touch = Touch(still[:, 0], along[:, 0], along, still)
    held = Coefficients(*(np.array([own]) for own in (nature.restitution, nature.friction, 0.0)))
    forces = RIG if nature.forces is None else nature.forces
    parted = press_by(forces, touch, held, Bodies.of(Sphere(), nature), lambda *_: still)
    return float((parted.velocity[0, 1] - parted.velocity[0, 0])[0] / 2.0)


TRUE = {
    "e": left_head_on(),
    "mu": PLAIN.friction,
    "lasting-contact.t": RIG.duration_s,
    "lasting-contact.kappa": RIG.stiffness_ratio,
    "lasting-contact.zeta": RIG.damping_ratio,
}


def run(options: Options) -> None:
    """Print the pulls of each parameter over many campaigns."""
    found = [_judged(FIRST_SEED + k, options) for k in range(options.campaigns)]
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


def _judged(seed: int, options: Options) -> Judged:
    drawn = max(float(np.random.default_rng(seed).normal(STATED_DRAG, STATED_ERROR)), 0.0)
    nature = replace(PLAIN, drag_coefficient=drawn)
    if options.slow_px is None:
        return judged(lasting_campaign(nature, seed, options.shots), (EFFECT,))
    data = filmed(nature, seed, options.shots, options.slow_px)
    return judged(replace(data, drag_coefficient=STATED_DRAG), (EFFECT,))


def _law(found: Judged) -> str | None:
    law = found.fit.theory.contact_law
    return None if law is None else law.title


def _pulls(found: Judged) -> list[float]:
    fitted = found.fit.parameters()
    return [(fitted[name].value - true) / fitted[name].sigma for name, true in TRUE.items()]
