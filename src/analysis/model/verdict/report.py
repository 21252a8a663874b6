"""A verdict as other programs read it."""

from __future__ import annotations

from typing import Any

from analysis.model.agreement.document import cell_document
from analysis.model.data.stream import CampaignData
from analysis.model.design.between import Telling
from analysis.model.design.document import shots_document
from analysis.model.fitting.nuisance import alarms_of, nuisances
from analysis.model.rank.candidate import Candidate, Ranking
from analysis.model.structure.alarm import UNEXPLAINED_LEVEL, is_shared
from analysis.model.structure.lackoffit import Cell
from analysis.model.verdict.documents import SMALLEST_P, noise_document
from analysis.model.verdict.selection import Verdict

Json = dict[str, Any]


def verdict_document(
    campaign: str, data: CampaignData, verdict: Verdict, following: Telling | None = None
) -> Json:
    """Return the document of `rigctl model explain --json`."""
    kept = verdict.cleaned.kept
    return {
        "campaign": campaign,
        "shots": len(data.shots) + len(data.unusable),
        "used": int(kept.sum()),
        "excluded": list(data.excluded),
        "rejected": sorted([*data.unusable, *(int(number) for number in data.shots[~kept])]),
        "rejected_frames": [list(frame) for frame in verdict.cleaned.frames],
        "torn_tracks": [list(track) for track in verdict.torn],
        "verdict": verdict.verdict,
        "effects": list(verdict.effects),
        "alias_set": list(verdict.alias_set),
        "alias_sets": {name: list(alike) for name, alike in verdict.alias_sets.items()},
        "unexplained": verdict.verdict == "unexplained",
        "chi2_per_dof": verdict.fit.chi2_per_dof,
        "p_chi2": max(verdict.fit.p_chi2, SMALLEST_P),
        "path": [
            {
                "with": list(stage.effects),
                "chi2_per_dof": stage.fit.chi2_per_dof,
                "prediction_error": stage.error.value,
            }
            for stage in verdict.path
        ],
        "parameters": {name: q.to_json() for name, q in verdict.fit.parameters().items()},
        "nuisances": [one.to_json() for one in nuisances(verdict.fit)],
        "alarms": alarms_of(verdict.fit),
        "candidates": candidates_document(verdict.first_ranking),
        "noise": noise_document(verdict.noise),
        "structure": [_cell(cell) for cell in _left(verdict, int(kept.sum()))],
        "next_shots": [] if following is None else shots_document(following.shots),
    }


def _left(verdict: Verdict, shots: int) -> list[Cell]:
    """Return the cells that stand out, those first that more than two shots speak for."""
    left = [cell for cell in verdict.cells if cell.p_holm < UNEXPLAINED_LEVEL]
    return sorted(left, key=lambda cell: (cell.of_measurement, not is_shared(cell, shots)))


def candidates_document(ranking: Ranking) -> list[Json]:
    """Return what can be seen of the candidates, the most promising first."""
    return [_candidate(candidate) for candidate in ranking.candidates if candidate.seen]


def _candidate(candidate: Candidate) -> Json:
    return {
        "effect": candidate.effect.name,
        "score": candidate.score,
        "p_value": max(candidate.p_value, SMALLEST_P),
        "p_familywise": candidate.p_familywise,
        "promised_fall": candidate.fall,
        "amplitude": float(candidate.amplitudes[0]),
        "sigma": float(candidate.sigmas[0]),
        "unit": candidate.effect.parameters[0].unit,
        "plausible": candidate.plausible,
        "of_measurement": candidate.of_measurement,
        "moved_m": candidate.moved_m,
        "plausible_range": list(candidate.effect.parameters[0].plausible),
    }


def _cell(cell: Cell) -> Json:
    return {**cell_document(cell), "of_measurement": cell.of_measurement}
