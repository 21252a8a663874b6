"""From scores to a verdict: which effects are missing, or none, or one that no catalogue holds.

Forward with re-ranking, one backward pass, then the lack-of-fit test. An effect is accepted when
its refit passes the family-wise level, no two shots carry it, and the error on shots left out
falls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2 as chi2_distribution

from analysis.effects.effect import Effect
from analysis.model.crossvalidation import PredictionError, prediction_error
from analysis.model.fit import Fit, fit_campaign
from analysis.model.inside import without_contact_frames
from analysis.model.lackoffit import Cell, lack_of_fit
from analysis.model.leaders import Leader, alias_set, in_order, refitted
from analysis.model.noise import noise_scales
from analysis.model.outliers import Cleaned, clean
from analysis.model.poses import PoseData
from analysis.model.ranking import Ranking, rank

FIRST_LEVEL, LATER_LEVEL = 0.03, 0.01
"""Family-wise level of the first acceptance and of each later one: the stricter keeps out shadows
of an effect already accepted."""
MOST_ACCEPTED, MOST_TRIED = 5, 3
DROP_LEVEL = 0.0015
UNEXPLAINED_LEVEL = 0.01
CONTRADICTED_SIGMAS = 4.0
"""Stated sigmas are taken at their word unless the scatter about free flight differs by so much."""


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """One point of the error path: the effects in, the fit, and the error on shots left out."""

    effects: tuple[str, ...]
    fit: Fit
    error: PredictionError


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """What is concluded.

    Attributes
    ----------
    verdict
        none, effect, alias or unexplained.
    effects
        Names of the accepted effects; when unexplained, what explains part.
    alias_set
        All that these shots cannot tell from an accepted effect, itself first: of the first that
        has company, else of the first.
    path
        From the base model on.
    ranking
        What the data ask for at the end.
    cells
        Structure that is left, the most striking first.
    cleaned
        What was used, and what was taken out.
    noise
        By what stated sigmas of positions and orientations were multiplied; 1: as stated.
    """

    verdict: str
    effects: tuple[str, ...]
    alias_set: tuple[str, ...]
    path: tuple[Stage, ...]
    ranking: Ranking
    first_ranking: Ranking
    cells: tuple[Cell, ...]
    cleaned: Cleaned
    noise: tuple[float, float]

    @property
    def fit(self) -> Fit:
        """The fit with everything accepted."""
        return self.path[-1].fit


def explain(
    data: PoseData,
    effects: Sequence[Effect],
    progress: Callable[[str], None] = lambda _: None,
) -> Verdict:
    """Go the whole way from the base model to a verdict."""
    progress("fitting the base model")
    outside = without_contact_frames(data)
    cleaned = clean(outside)
    outside, noise = _with_real_noise(outside, cleaned)
    if noise != (1.0, 1.0):
        cleaned = clean(outside)
    path = [_stage(cleaned.data, cleaned.fit)]
    first_ranking = ranking = rank(cleaned.data, cleaned.fit, effects)
    alias_sets: dict[str, tuple[str, ...]] = {}
    while len(path) <= MOST_ACCEPTED:
        progress(f"refitting the leaders, {len(path) - 1} effects accepted")
        level = FIRST_LEVEL if len(path) == 1 else LATER_LEVEL
        leaders = refitted(cleaned.data, path[-1].fit, ranking, level)
        accepted = _accepted(cleaned.data, path[-1], leaders)
        if accepted is None:
            break
        leader, stage = accepted
        alias_sets[leader.name] = alias_set(leader, leaders)
        path.append(stage)
        cleaned, path = _brought_back(outside, cleaned, path)
        ranking = rank(cleaned.data, path[-1].fit, effects)
    path = _backward(cleaned.data, path)
    progress("testing what is left")
    cells = lack_of_fit(cleaned.data, path[-1].fit)
    names = path[-1].effects
    ambiguous = [name for name in names if len(alias_sets[name]) > 1]
    return Verdict(
        verdict=_word(names, alias_sets, cells),
        effects=names,
        alias_set=next((alias_sets[name] for name in (*ambiguous, *names)), ()),
        path=tuple(path),
        ranking=ranking,
        first_ranking=first_ranking,
        cells=cells,
        cleaned=cleaned,
        noise=noise,
    )


def _with_real_noise(data: PoseData, cleaned: Cleaned) -> tuple[PoseData, tuple[float, float]]:
    """Return the data with sigmas of either kind corrected where the scatter contradicts them."""
    factors = [
        scale.value if abs(scale.value - 1) > CONTRADICTED_SIGMAS * scale.sigma else 1.0
        for scale in noise_scales(cleaned.data, cleaned.fit)
    ]
    position, rotation = factors
    scaled = data.with_sigmas(position * data.position_sigma, rotation * data.rotation_sigma)
    return scaled, (position, rotation)


def _accepted(
    data: PoseData, present: Stage, leaders: Sequence[Leader]
) -> tuple[Leader, Stage] | None:
    """Return the first leader that brings down the error on shots left out, at convergence."""
    for leader in in_order(leaders)[:MOST_TRIED]:
        stage = _stage(data, fit_campaign(data, leader.fit.theory, leader.fit))
        if stage.error.value < present.error.value:
            return leader, stage
    return None


def _brought_back(
    data: PoseData, cleaned: Cleaned, path: list[Stage]
) -> tuple[Cleaned, list[Stage]]:
    """Test dropped shots and frames against the theory as it is now; those it explains come back.

    The whole path is then fitted to the same shots, so that its errors compare.
    """
    if cleaned.kept.all() and not cleaned.frames:
        return cleaned, path
    again = clean(data, path[-1].fit.theory)
    same = np.array_equal(again.kept, cleaned.kept) and again.frames == cleaned.frames
    if same:
        return cleaned, path
    earlier = [
        _stage(again.data, fit_campaign(again.data, stage.fit.theory)) for stage in path[:-1]
    ]
    return again, [*earlier, _stage(again.data, again.fit)]


def _word(
    accepted: tuple[str, ...], alias_sets: dict[str, tuple[str, ...]], cells: tuple[Cell, ...]
) -> str:
    if cells and cells[0].p_holm < UNEXPLAINED_LEVEL:
        return "unexplained"
    if not accepted:
        return "none"
    return "alias" if any(len(alias_sets[name]) > 1 for name in accepted) else "effect"


def _stage(data: PoseData, fit: Fit) -> Stage:
    names = tuple(active.effect.name for active in fit.theory.active)
    return Stage(names, fit, prediction_error(data, fit))


def _backward(data: PoseData, path: list[Stage]) -> list[Stage]:
    """Drop, worst first, whatever the effects accepted after it have made superfluous."""
    last = path[-1]
    while len(last.effects) > 1:
        without = [
            fit_campaign(data, last.fit.theory.without_effect(name), last.fit)
            for name in last.effects
        ]
        losses = np.array([fit.chi2 - last.fit.chi2 for fit in without]) / last.fit.chi2_per_dof
        sizes = np.array([len(active.values) for active in last.fit.theory.active])
        p_values = np.asarray(chi2_distribution.sf(losses, sizes))
        worst = int(p_values.argmax())
        if p_values[worst] < DROP_LEVEL:
            break
        last = _stage(data, without[worst])
        path = [*path, last]
    return path
