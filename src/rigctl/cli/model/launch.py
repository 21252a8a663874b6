"""`rigctl model launch`: from the settings of a campaign to the mouths of the tubes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from analysis.campaign import SHOT_LIST
from analysis.effects.catalogue import LAUNCH_CATALOGUE
from analysis.effects.effect import LaunchEffect
from analysis.effects.launch.pressure_friction import EFFECT as FRICTION
from analysis.errors import InputError, LaunchRefusedError
from analysis.launch.agreement import LaunchAgreement, agreement_of
from analysis.launch.fit import fit_launch
from analysis.launch.ranking import LaunchCandidate, LaunchRanking, rank_launch
from analysis.launch.result import LaunchFit
from analysis.launch.settings import read_settings, settings_of
from analysis.model.data.inside import without_contact_frames
from analysis.model.data.stream import whole
from analysis.model.fitting.outliers import clean
from analysis.quantity import Quantity
from analysis.schema.codec import SMALLEST_P
from rigctl.cli.options import Campaign, Config, Json, With
from rigctl.cli.output import TABLE_WIDTH, plain_table, print_json, unit_word
from rigctl.errors import AnalysisInputError, NotFoundError
from rigctl.model.campaigns import open_campaign

SHOWN_ALIAS = 0.9


def launch(
    campaign: Campaign, *, effects: With = None, config: Config = None, json: Json = False
) -> None:
    """Fit the launches of a campaign and rank the effects of the launch; print both.

    Raises
    ------
    AnalysisInputError
        The campaign cannot be read, or its settings do not let launches be fitted.
    NotFoundError
        No effect of the launch has that name.
    """
    added = [_effect(name) for name in dict.fromkeys(effects or [])]
    title, fitted = _fitted(campaign, config, [FRICTION, *(e for e in added if e is not FRICTION)])
    ranked = rank_launch(fitted, LAUNCH_CATALOGUE)
    if json:
        print_json(_document(title, fitted, ranked))
        return
    console = Console(width=TABLE_WIDTH)
    end = "" if fitted.converged else "; the fit has not settled"
    console.print(f"{title}: launches of {fitted.shots.size} shots{end}", highlight=False)
    if fitted.rejected.size:
        console.print(f"shots rejected as misfires: {fitted.rejected.tolist()}", highlight=False)
    for table in (_parameters(fitted), _quantities(agreement_of(fitted)), _candidates(ranked)):
        console.print(table)


def _fitted(
    campaign: Path, configuration: Path | None, effects: Sequence[LaunchEffect]
) -> tuple[str, LaunchFit]:
    """Fit the launches to a campaign's poses, wild frames and bad shots left out."""
    title, poses = open_campaign(campaign, configuration, poses=True)
    cleaned = clean(without_contact_frames(poses))
    data, shot_list = whole(cleaned.data), campaign / SHOT_LIST
    try:
        known = read_settings(shot_list, data.shots) if shot_list.exists() else settings_of(data)
        return title, fit_launch(data, cleaned.fit, effects, settings=known)
    except InputError as error:
        place = error.path if error.line is None else f"{error.path}, line {error.line}"
        raise AnalysisInputError(error.reason, part=place) from error
    except LaunchRefusedError as error:
        raise AnalysisInputError(f"no launch can be fitted: {error}", part=title) from error


def _effect(name: str) -> LaunchEffect:
    known = {effect.name: effect for effect in LAUNCH_CATALOGUE}
    if name not in known:
        raise NotFoundError(
            "no effect of the launch has this name",
            part="--with",
            value=repr(name),
            todo=f"choose one of {', '.join(sorted(known))}",
        )
    return known[name]


def _document(title: str, fitted: LaunchFit, ranked: LaunchRanking) -> dict[str, Any]:
    return {
        "campaign": title,
        "shots": fitted.shots.size,
        "rejected": fitted.rejected.tolist(),
        "with": [active.effect.name for active in fitted.theory.active],
        "converged": fitted.converged,
        "parameters": {name: q.to_json() for name, q in fitted.parameters().items()},
        "quantities": [asdict(row) for row in agreement_of(fitted)],
        "candidates": [_candidate(one, _likes(ranked, k)) for k, one in _numbered(ranked)],
    }


def _candidate(candidate: LaunchCandidate, likes: list[str]) -> dict[str, Any]:
    seen = candidate.seen
    return {
        "effect": candidate.effect.name,
        "fitted": candidate.fitted,
        "seen": seen,
        "score": candidate.score if seen else None,
        "promised_fall": candidate.delta_chi2,
        "p_value": max(candidate.p_value, SMALLEST_P),
        "p_familywise": candidate.p_familywise,
        "plausible": candidate.plausible if seen else None,
        "amplitudes": {
            symbol: quantity.to_json() for symbol, quantity in _amplitudes(candidate).items()
        }
        if seen
        else {},
        "like": likes,
    }


def _amplitudes(candidate: LaunchCandidate) -> dict[str, Quantity]:
    rows = zip(candidate.effect.parameters, candidate.amplitudes, candidate.sigmas, strict=True)
    return {p.symbol: Quantity(float(a), float(s), p.unit) for p, a, s in rows}


def _numbered(ranked: LaunchRanking) -> list[tuple[int, LaunchCandidate]]:
    return list(enumerate(ranked.candidates))


def _likes(ranked: LaunchRanking, k: int) -> list[str]:
    return [
        other.effect.name
        for j, other in _numbered(ranked)
        if j != k and ranked.aliases[k, j] > SHOWN_ALIAS
    ]


def _parameters(fitted: LaunchFit) -> Table:
    table = plain_table(("parameter", "value", "unit"), title="pushers and tubes")
    for name, quantity in fitted.parameters().items():
        table.add_row(name, quantity.concise(), unit_word(quantity.unit))
    return table


def _quantities(rows: Sequence[LaunchAgreement]) -> Table:
    table = plain_table(
        ("quantity", "unit"),
        ("scatter", "prediction error", "n"),
        title="foretold from the settings",
    )
    for row in rows:
        table.add_row(
            row.quantity,
            row.unit,
            f"{row.scatter:.3g}",
            f"{row.prediction_rms:.3g}",
            str(row.count),
        )
    table.caption = "prediction error: root mean square, each shot by the parameters of the others"
    return table


def _candidates(ranked: LaunchRanking) -> Table:
    table = plain_table(("effect", "amplitude", ""), ("score", "p"), title="effects")
    table.add_column("like")
    for k, candidate in _numbered(ranked):
        if not candidate.seen:
            table.add_row(candidate.effect.name, "cannot be seen with these settings")
            continue
        amplitudes = ", ".join(
            f"{symbol} = {quantity.concise()} {unit_word(quantity.unit)}".rstrip()
            for symbol, quantity in _amplitudes(candidate).items()
        )
        remarks = [
            *(["in the fit"] if candidate.fitted else []),
            *([] if candidate.plausible else ["not plausible"]),
        ]
        table.add_row(
            candidate.effect.name,
            amplitudes,
            ", ".join(remarks),
            f"{candidate.score:.1f}",
            f"{candidate.p_familywise:.4f}",
            ", ".join(_likes(ranked, k)),
        )
    return table
