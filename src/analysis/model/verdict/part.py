"""Which of the accepted effects explain part of what no catalogue holds.

On the way to `unexplained` effects are accepted that take a little of something else. Beside that
word stand only those without which shots left out would be foretold worse: by more than chance,
and by a part of the error that is worth a name.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis.model.data.evidence import Stage, stage_of
from analysis.model.data.stream import CampaignData
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.rank.candidate import believed

LEAST_SAMPLINGS = 2.0
"""Sampling errors of the prediction error by which an effect must lower it."""
LEAST_SHARE = 0.05
"""Of what could be removed, from the base model's error down to the noise."""
LEAST_SIGMAS = 2.0
"""A value nearer to where the effect is off is not determined by these shots."""


def what_explains(data: CampaignData, path: Sequence[Stage]) -> tuple[Stage, ...]:
    """Return a path without the effects that explain nothing, dropped one by one, worst first."""
    kept = list(path)
    while kept[-1].fit.theory.active:
        last = kept[-1]
        gains = {
            active.effect.name: _without(data, last, active.effect.name)
            for active in last.fit.theory.active
        }
        idle = [name for name, (gain, _) in gains.items() if not _explains(kept, name, gain)]
        if not idle:
            break
        kept.append(gains[min(idle, key=lambda name: gains[name][0])][1])
    return tuple(kept)


def _without(data: CampaignData, last: Stage, name: str) -> tuple[float, Stage]:
    """Return by how much the error rises without an effect, and the stage without it."""
    rest = stage_of(data, fit_campaign(data, last.fit.theory.without_effect(name), last.fit))
    return rest.error.value - last.error.value, rest


def _explains(path: Sequence[Stage], name: str, gain: float) -> bool:
    last = path[-1]
    least = LEAST_SHARE * (path[0].error.value - 1.0)
    return gain > LEAST_SAMPLINGS * last.error.sampling and gain >= least and _sure(last.fit, name)


def _sure(fit: Fit, name: str) -> bool:
    """Whether an effect is inside its believed range, and away from where it is off."""
    start = fit.theory.given
    sigmas = np.sqrt(np.diag(fit.covariance) * fit.chi2_per_dof)
    for active in fit.theory.active:
        stop = start + len(active.values)
        if active.effect.name == name:
            own = sigmas[start:stop]
            far = np.abs(active.values - active.effect.off) > LEAST_SIGMAS * own
            return believed(active.effect, active.values, own) and bool(far.any())
        start = stop
    return False
