"""A fit, a ranking and a verdict as the models that other programs read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from analysis.model.agreement.document import tested_cell
from analysis.model.data.stream import CampaignData
from analysis.model.design.between import Telling
from analysis.model.design.document import next_shots
from analysis.model.fitting.account import Accounted
from analysis.model.fitting.nuisance import alarms_of, nuisances
from analysis.model.rank.candidate import Candidate, Ranking
from analysis.model.structure.alarm import UNEXPLAINED_LEVEL, is_shared
from analysis.model.structure.lackoffit import Cell
from analysis.model.verdict.selection import Verdict
from analysis.quantity import Quantity
from analysis.schema.codec import SMALLEST_P, Json, written
from analysis.schema.verdict import (
    FitReport,
    LeftCell,
    NoiseFactors,
    PathStage,
    RankedCandidate,
    SeenCandidate,
    VerdictReport,
)

SHOWN_ALIAS = 0.9
"""Effects whose traces in the residuals correlate more than this are named as alike,"""
SHOWN_APART, PROMISE_ERRS = 0.1, 0.02
"""unless one leaves more than the other by the first share of the noise, and by the second of the
promised fall, which is not exact: these shots distinguish them."""


def fit_document(title: str, names: Sequence[str], found: Accounted) -> Json:
    """Return the JSON of a campaign's fit with the effects that were added, by name."""
    return written(fit_report(title, names, found))


def fit_report(title: str, names: Sequence[str], found: Accounted) -> FitReport:
    """Return a campaign's fit with the effects that were added, by name."""
    fit, account = found.fit, found.account
    return FitReport(
        campaign=title,
        shots=len(fit.shot_chi2),
        excluded=tuple(account.excluded),
        rejected=tuple(account.rejected),
        rejected_why=tuple(account.rejected.values()),
        rejected_frames=account.frames,
        torn_tracks=account.torn,
        noise=NoiseFactors(*account.noise),
        effects=tuple(names),
        chi2_per_dof=fit.chi2_per_dof,
        degrees_of_freedom=fit.freedom,
        converged=fit.converged,
        parameters=fit.parameters(),
        formulas=fit.formulas(),
        nuisances=nuisances(fit),
        alarms=alarms_of(fit),
    )


def verdict_document(
    campaign: str, data: CampaignData, verdict: Verdict, following: Telling | None = None
) -> Json:
    """Return the JSON of a verdict, as `rigctl model explain --json` prints it."""
    return written(verdict_report(campaign, data, verdict, following))


def verdict_report(
    campaign: str, data: CampaignData, verdict: Verdict, following: Telling | None = None
) -> VerdictReport:
    """Return what is concluded of a campaign, with the shots that would end the doubts."""
    kept, fit = verdict.cleaned.kept, verdict.fit
    used = int(kept.sum())
    return VerdictReport(
        campaign=campaign,
        shots=len(data.shots) + len(data.unusable),
        used=used,
        excluded=tuple(data.excluded),
        rejected=tuple(sorted([*data.unusable, *map(int, data.shots[~kept])])),
        rejected_frames=verdict.cleaned.frames,
        torn_tracks=verdict.torn,
        verdict=verdict.verdict,
        effects=verdict.effects,
        alias_set=verdict.alias_set,
        alias_sets=verdict.alias_sets,
        unexplained=verdict.verdict == "unexplained",
        chi2_per_dof=fit.chi2_per_dof,
        p_chi2=max(fit.p_chi2, SMALLEST_P),
        path=tuple(
            PathStage(stage.effects, stage.fit.chi2_per_dof, stage.error.value)
            for stage in verdict.path
        ),
        parameters=fit.parameters(),
        formulas=fit.formulas(),
        nuisances=nuisances(fit),
        alarms=alarms_of(fit),
        candidates=tuple(_seen(one) for one in verdict.first_ranking.candidates if one.seen),
        noise=NoiseFactors(*verdict.noise),
        structure=tuple(map(_left_cell, _left(verdict, used))),
        next_shots=() if following is None else next_shots(following.shots),
    )


def _left(verdict: Verdict, shots: int) -> list[Cell]:
    """Return the cells that stand out, those first that more than two shots carry."""
    left = [cell for cell in verdict.cells if cell.p_holm < UNEXPLAINED_LEVEL]
    return sorted(left, key=lambda cell: (cell.of_measurement, not is_shared(cell, shots)))


def _left_cell(cell: Cell) -> LeftCell:
    return LeftCell(**asdict(tested_cell(cell)), of_measurement=cell.of_measurement)


def _seen(candidate: Candidate) -> SeenCandidate:
    first = candidate.effect.parameters[0]
    return SeenCandidate(
        effect=candidate.effect.name,
        score=candidate.score,
        p_value=max(candidate.p_value, SMALLEST_P),
        p_familywise=candidate.p_familywise,
        delta_chi2=candidate.delta_chi2,
        amplitude=float(candidate.amplitudes[0]),
        sigma=float(candidate.sigmas[0]),
        unit=first.unit,
        plausible=candidate.plausible,
        of_measurement=candidate.of_measurement,
        moved_m=candidate.moved_m,
        plausible_range=first.plausible,
    )


def ranking_document(ranked: Ranking) -> list[Json]:
    """Return the JSON of all candidates, the most promising first."""
    return [written(one) for one in ranked_candidates(ranked)]


def ranked_candidates(ranked: Ranking) -> list[RankedCandidate]:
    """Return all candidates, the most promising first; what cannot be seen has no numbers."""
    return [
        RankedCandidate(
            effect=candidate.effect.name,
            seen=candidate.seen,
            score=candidate.score if candidate.seen else None,
            delta_chi2=candidate.delta_chi2,
            p_value=max(candidate.p_value, SMALLEST_P),
            p_familywise=candidate.p_familywise,
            plausible=candidate.plausible if candidate.seen else None,
            of_measurement=candidate.of_measurement,
            moved_m=candidate.moved_m,
            amplitude=float(candidate.amplitudes[0]) if candidate.seen else None,
            unit=candidate.effect.parameters[0].unit,
            amplitudes=_amplitudes(candidate) if candidate.seen else {},
            like=tuple(alike(ranked, k)),
        )
        for k, candidate in enumerate(ranked.candidates)
    ]


def alike(ranked: Ranking, k: int) -> list[str]:
    """Return the effects that these shots do not tell from the candidate in place k."""
    own = ranked.candidates[k].delta_chi2
    most = max(SHOWN_APART * ranked.freedom / ranked.noise_scale**2, PROMISE_ERRS * own)
    return [
        other.effect.name
        for j, other in enumerate(ranked.candidates)
        if j != k and ranked.aliases[k, j] > SHOWN_ALIAS and abs(other.delta_chi2 - own) < most
    ]


def _amplitudes(candidate: Candidate) -> dict[str, Quantity]:
    rows = zip(candidate.effect.parameters, candidate.amplitudes, candidate.sigmas, strict=True)
    return {p.symbol: Quantity(float(a), float(s), p.unit) for p, a, s in rows}
