"""What is taken as the evidence of a campaign: which shots and frames, and with which noise.

Stated sigmas are used as they are unless the scatter about free flight contradicts them. Slow
errors are stated beside them, and what of these changes within a flight scatters too: sigmas are
enlarged by the scatter as far as that explains it. Sigmas of a table that states none are the
scatter about the theory as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from analysis.effects.clock.timing_jitter import EFFECT as JITTER
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable
from analysis.model.data.tables_build import with_scatter_as_noise
from analysis.model.fitting.account import AS_STATED
from analysis.model.fitting.fit import Fit, beside_field, fit_campaign
from analysis.model.fitting.noise import NoiseScale, noise_scales
from analysis.model.fitting.outliers import Cleaned, clean
from analysis.model.predict.theory import Theory
from analysis.model.verdict.crossvalidation import PredictionError, prediction_error

CONTRADICTED_SIGMAS = 4.0
LEAST_CHANGE = 0.003
"""Of sigmas, below which they are the same: chi-squared changes by less than 0.01 per degree."""


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """A campaign ready to be judged.

    Attributes
    ----------
    stated
        Every shot, sigmas as stated.
    cleaned
        Without bad frames and shots, sigmas as they really are.
    noise
        By what stated sigmas of positions and of orientations were multiplied.
    """

    stated: CampaignData
    cleaned: Cleaned
    noise: tuple[float, float]

    @property
    def data(self) -> CampaignData:
        """What is left."""
        return self.cleaned.data

    @property
    def whole(self) -> CampaignData:
        """Every shot, sigmas as they really are."""
        if isinstance(self.stated, ContactTable):
            return self.stated
        return self.stated.with_noise(*self.noise)


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """One point of the error path: the effects in, the fit, and the error on shots left out."""

    effects: tuple[str, ...]
    fit: Fit
    error: PredictionError


def weighed(stated: CampaignData, theory: Theory | None = None) -> Evidence:
    """Take out what is bad and correct the sigmas, judged by a theory (None: the base model)."""
    if isinstance(stated, ContactTable) and stated.estimated:
        stated = with_scatter_as_noise(stated, theory)
    cleaned = clean(stated, theory)
    noise = corrections(noise_scales(cleaned.data, cleaned.fit))
    if noise != AS_STATED and not isinstance(stated, ContactTable):
        cleaned = clean(stated.with_noise(*noise), cleaned.fit.theory)
    fit = beside_field(cleaned.data, cleaned.fit)
    return Evidence(stated, replace(cleaned, fit=fit), noise)


def corrections(scales: tuple[NoiseScale, NoiseScale]) -> tuple[float, float]:
    """Return by what to multiply sigmas: 1 where the scatter is as stated."""
    position, rotation = map(_correction, scales)
    return position, rotation


def _correction(scale: NoiseScale) -> float:
    if abs(scale.value - 1) > CONTRADICTED_SIGMAS * scale.sigma:
        return scale.value
    enlarged = min(scale.value, scale.by_slow)
    return enlarged if enlarged > 1 + LEAST_CHANGE else 1.0


def stage_of(data: CampaignData, fit: Fit, error: PredictionError | None = None) -> Stage:
    """Return the point of the error path that a fit is.

    Parameters
    ----------
    error
        On shots left out at random, where it is known already.
    """
    names = tuple(active.effect.name for active in fit.theory.active)
    if data.jitter_s > 0:
        names = (*names, JITTER.name)
    own = prediction_error(data, fit) if error is None else error
    return Stage(names, beside_field(data, fit), own)


def weighed_again(
    evidence: Evidence, path: list[Stage], jitter_s: float
) -> tuple[Evidence, list[Stage]]:
    """Judge shots, frames and noise by the theory as it is now; what it explains comes back.

    The whole path is then fitted to the same shots, so that its errors compare.
    """
    kept = evidence.cleaned
    same_noise = evidence.noise == AS_STATED and jitter_s == evidence.stated.jitter_s
    if kept.kept.all() and not kept.frames and same_noise and not _estimated(evidence.stated):
        return evidence, path
    again = weighed(with_jitter(evidence.stated, jitter_s), path[-1].fit.theory)
    changed = (
        not np.array_equal(again.cleaned.kept, kept.kept)
        or again.cleaned.frames != kept.frames
        or not np.allclose(again.noise, evidence.noise, rtol=0, atol=LEAST_CHANGE)
        or _estimated(evidence.stated)
    )
    if not changed:
        return replace(again, cleaned=replace(kept, data=again.data)), path
    refit = _refitter(again.data)
    last = replace(again.cleaned.fit, scatter=path[-1].fit.scatter)
    return again, [*(refit(stage) for stage in path[:-1]), stage_of(again.data, last)]


def _estimated(data: CampaignData) -> bool:
    return isinstance(data, ContactTable) and data.estimated


def with_jitter(data: CampaignData, jitter_s: float) -> CampaignData:
    """Return a campaign whose frames come early or late by this much, s; a table has no frames."""
    return data if isinstance(data, ContactTable) else replace(data, jitter_s=jitter_s)


def _refitter(data: CampaignData) -> Callable[[Stage], Stage]:
    def refit(stage: Stage) -> Stage:
        own = data if JITTER.name in stage.effects else with_jitter(data, 0.0)
        return stage_of(own, fit_campaign(own, stage.fit.theory))

    return refit
