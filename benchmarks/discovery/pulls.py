"""Whether a fitted contact is as far from the simulator's as its stated errors say.

Of each parameter of a contact that lasts: the root mean square of its pulls, the error over the
stated one. Poses scatter as they are stated, and the drag of the air is drawn from what is stated
of it. A campaign whose force law is taken for another has the other's parameters and counts apart.
With --slow-px poses are as exact as filmed ones, and err as is stated of those: slowly as well, and
all alike by scale, outlines and orientations. Scale and drag are one draw for a campaign, and most
of the error of e and v_n: over the campaigns they are quantiles of what is stated, so that few
spread as many would. Then v_n, v_n' and e of single shots, and the report's mean e, are held
against the world's as well. An own pull is the error less what the drawn scale and drag do to it,
over the shot's own error; a total pull is the whole error over the whole stated one. How large
slow errors come out of a campaign's flights is held against what was drawn, too. Each campaign is
fitted once more streamed, a part of its shots at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import norm

from analysis.arrays import Floats
from analysis.effects.contact.lasting_contact import EFFECT
from analysis.model.data.inside import without_contact_frames
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import PoseStream
from analysis.model.fitting.robust_fit import RobustFit, robust_fit
from analysis.model.fitting.slow_errors.sizes import with_measured_slow_errors
from benchmarks.discovery.filmed_errors import filmed
from benchmarks.discovery.goals import Goal, report, share
from benchmarks.discovery.lasting import PLAIN, RIG, STATED_DRAG, lasting_campaign
from benchmarks.discovery.options import Options
from benchmarks.discovery.single_shots import DRAG, SCALE, of_single_shots
from simulators.challenge.bodies import Bodies
from simulators.challenge.coefficients import Coefficients
from simulators.challenge.forces import press_by
from simulators.challenge.launch import Touch
from simulators.challenge.nature import Nature
from simulators.world.description import Sphere

FIRST_SEED = 600_000
STATED_ERROR = 0.2
LEAST, MOST = 0.8, 1.25
MOST_APART = 0.01
"""Errors, between a fit in memory and the streamed one."""


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
    """Print the pulls of each parameter over many campaigns, and of single shots where filmed."""
    shared = drawn_shared(options.campaigns)
    data = (_campaign(k, options, shared[:, k]) for k in range(options.campaigns))
    single: dict[str, list[Floats]] = {}
    found, streamed, slow = [], [], []
    for k, one in enumerate(data):
        found.append(robust_fit(one, (EFFECT,)))
        streamed.append(robust_fit(PoseStream.of(one.parts()), (EFFECT,)))
        if options.slow_px is not None:
            whole = with_measured_slow_errors(without_contact_frames(one))
            slow.append(whole.slow.position_m / one.slow.position_m)
            nature = _nature(float(shared[DRAG, k]))
            for name, pulls in of_single_shots(one, nature, FIRST_SEED + k, shared[:, k]).items():
                single.setdefault(name, []).append(pulls)
    if slow:
        print(f"  slow errors found over drawn: {min(slow):.2f} to {max(slow):.2f}")
    goals = [*_of_fits("", found), *_of_fits(", streamed", streamed), _apart(found, streamed)]
    for name, parts in single.items():
        goals += _goals(name, np.concatenate(parts))
    report("pulls", goals, [])


def _of_fits(way: str, found: Sequence[RobustFit]) -> list[Goal]:
    """Return how often another law is taken, and the pulls of each parameter where none is."""
    others = [_law(one) != EFFECT.title for one in found]
    right = [_pulls(one) for one in found if _law(one) == EFFECT.title]
    goals = [share(f"force law taken for another{way}", 0.05, others, at_least=False)]
    for name, own in zip(TRUE, np.array(right).reshape(-1, len(TRUE)).T, strict=True):
        goals += _goals(f"{name}{way}", own)
    return goals


def _apart(found: Sequence[RobustFit], streamed: Sequence[RobustFit]) -> Goal:
    """Return by how many errors two ways to fit the same poses differ at most."""
    pairs = zip(map(_pulls, found), map(_pulls, streamed), strict=True)
    apart = max(float(np.abs(np.subtract(*pair)).max()) for pair in pairs)
    text = "fitted in memory and streamed: largest difference, errors"
    return Goal(text, MOST_APART, apart, 0.0, len(found), at_least=False)


def drawn_shared(campaigns: int) -> Floats:
    """Return scale and drag of each campaign in stated errors, shape (2, campaigns): quantiles."""
    quantiles = norm.ppf((np.arange(campaigns) + 0.5) / campaigns)
    rng = np.random.default_rng(FIRST_SEED)
    return np.stack([rng.permutation(quantiles) for _ in range(2)])


def _goals(name: str, pulls: Floats) -> list[Goal]:
    size = float(np.sqrt((pulls**2).mean()))
    error = size / np.sqrt(2 * len(pulls))
    print(f"  {name:24} mean {pulls.mean():+.2f}, worst {np.abs(pulls).max():.1f}")
    return [
        Goal(f"{name}: pulls, rms", LEAST, size, error, len(pulls)),
        Goal(f"{name}: pulls, rms", MOST, size, error, len(pulls), at_least=False),
    ]


def _nature(drag_pull: float) -> Nature:
    return replace(PLAIN, drag_coefficient=max(STATED_DRAG + STATED_ERROR * drag_pull, 0.0))


def _campaign(number: int, options: Options, shared: Floats) -> PoseData:
    nature, seed = _nature(float(shared[DRAG])), FIRST_SEED + number
    if options.slow_px is None:
        return lasting_campaign(nature, seed, options.shots)
    pull, slow_px = float(shared[SCALE]), options.slow_px
    data = filmed(nature, seed, options.shots, slow_px, pull, by_place=options.by_place)
    return replace(data, drag_coefficient=STATED_DRAG)


def _law(found: RobustFit) -> str | None:
    law = found.fit.theory.contact_law
    return None if law is None else law.title


def _pulls(found: RobustFit) -> list[float]:
    fitted = found.fit.parameters()
    return [(fitted[name].value - true) / fitted[name].sigma for name, true in TRUE.items()]
