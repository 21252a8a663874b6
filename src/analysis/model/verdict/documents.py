"""A fit and a ranking as other programs read them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from analysis.model.fitting.account import Accounted
from analysis.model.fitting.nuisance import alarms_of, nuisances
from analysis.model.rank.candidate import Candidate, Ranking
from analysis.quantity import Quantity

Json = dict[str, Any]

SMALLEST_P = 1e-300
"""No chance is less than this in a document: some readers take a smaller number for none."""
SHOWN_ALIAS = 0.9
"""Effects whose traces in the residuals correlate more than this are named as alike."""


def fit_document(title: str, names: Sequence[str], found: Accounted) -> Json:
    """Return a campaign's fit with the effects that were added, by name."""
    fit, account = found.fit, found.account
    return {
        "campaign": title,
        "shots": len(fit.shot_chi2),
        "excluded": account.excluded,
        "rejected": account.rejected,
        "rejected_frames": [list(frame) for frame in account.frames],
        "torn_tracks": [list(track) for track in account.torn],
        "noise": noise_document(account.noise),
        "with": list(names),
        "chi2_per_dof": fit.chi2_per_dof,
        "degrees_of_freedom": fit.freedom,
        "converged": fit.converged,
        "parameters": {name: q.to_json() for name, q in fit.parameters().items()},
        "nuisances": [one.to_json() for one in nuisances(fit)],
        "alarms": alarms_of(fit),
    }


def noise_document(noise: tuple[float, float]) -> Json:
    """Return by what stated sigmas were multiplied."""
    return {"position": noise[0], "orientation": noise[1]}


def ranking_document(ranked: Ranking) -> list[Json]:
    """Return all candidates, the most promising first; what cannot be seen has no numbers."""
    return [
        {
            "effect": candidate.effect.name,
            "seen": candidate.seen,
            "score": candidate.score if candidate.seen else None,
            "promised_fall": candidate.fall,
            "p_value": max(candidate.p_value, SMALLEST_P),
            "p_familywise": candidate.p_familywise,
            "plausible": candidate.plausible if candidate.seen else None,
            "of_measurement": candidate.of_measurement,
            "moved_m": candidate.moved_m,
            "amplitude": float(candidate.amplitudes[0]) if candidate.seen else None,
            "unit": candidate.effect.parameters[0].unit,
            "amplitudes": _amplitudes(candidate) if candidate.seen else {},
            "like": alike(ranked, k),
        }
        for k, candidate in enumerate(ranked.candidates)
    ]


def alike(ranked: Ranking, k: int) -> list[str]:
    """Return the effects that these shots do not tell from the candidate in place k."""
    return [
        other.effect.name
        for j, other in enumerate(ranked.candidates)
        if j != k and ranked.aliases[k, j] > SHOWN_ALIAS
    ]


def _amplitudes(candidate: Candidate) -> Json:
    rows = zip(candidate.effect.parameters, candidate.amplitudes, candidate.sigmas, strict=True)
    return {p.symbol: Quantity(float(a), float(s), p.unit).to_json() for p, a, s in rows}
