"""`rigctl model`: a campaign's poses against the model, and the effects it would rather have."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from analysis.effects.own.dropping import without_faulty
from analysis.effects.own.fault import EffectFault
from analysis.errors import InputError
from analysis.model.fit import Fit, fit_campaign
from analysis.model.gather import gather
from analysis.model.inside import without_contact_frames
from analysis.model.poses import PoseData
from analysis.model.ranking import Candidate, Ranking, rank
from analysis.model.report import verdict_document, verdict_sentence
from analysis.model.selection import explain
from analysis.quantity import Quantity
from rigctl.commands import report
from rigctl.commands.effect import Available, available, refused, tell
from rigctl.errors import AnalysisInputError

SHOWN_ALIAS = 0.9
TABLE_WIDTH = 110


def fit(campaign: Path, names: Sequence[str], *, as_json: bool, folder: Path | None = None) -> None:
    """Fit the base model and the named effects; print parameters with standard errors.

    Parameters
    ----------
    folder
        Where the user's own effects are.

    Raises
    ------
    AnalysisInputError
        The campaign or the folder cannot be read, or a named effect has a fault.
    NotFoundError
        No effect has that name.
    """
    known = available(folder)
    title, _, fitted = _fitted(campaign, names, known)
    faults = tell(known.faults)
    if as_json:
        _print_json({"campaign": title, **_fit_document(fitted, names), "faults": faults})
        return
    console = Console(width=TABLE_WIDTH)
    console.print(_headline(title, fitted), highlight=False)
    table = Table(box=None)
    for heading in ("parameter", "value", "unit"):
        table.add_column(heading, justify="left" if heading != "value" else "right")
    for name, quantity in fitted.parameters().items():
        table.add_row(name, quantity.concise(), "" if quantity.unit == "1" else quantity.unit)
    console.print(table)


def ranking(
    campaign: Path, names: Sequence[str], *, as_json: bool, folder: Path | None = None
) -> None:
    """Fit the base model and the named effects, and rank what else the data ask for.

    Parameters
    ----------
    folder
        Where the user's own effects are. One with a fault is named and left out.

    Raises
    ------
    AnalysisInputError
        The campaign or the folder cannot be read, or a named effect has a fault.
    NotFoundError
        No effect has that name.
    """
    known = available(folder)
    title, data, fitted = _fitted(campaign, names, known)
    try:
        ranked, dropped = without_faulty(known.effects, lambda left: rank(data, fitted, left))
    except EffectFault as error:
        raise refused(error.fault) from error
    faults = tell([*known.faults, *dropped])
    if as_json:
        document = {"campaign": title, **_fit_document(fitted, names)}
        _print_json({**document, "candidates": _candidates_document(ranked), "faults": faults})
        return
    console = Console(width=TABLE_WIDTH)
    console.print(_headline(title, fitted), highlight=False)
    table = Table(box=None)
    longest = max((len(candidate.effect.name) for candidate in ranked.candidates), default=0)
    table.add_column("effect", min_width=longest)
    for heading in ("score", "promised fall", "p", "amplitude", "unit", "", "like"):
        left = heading in {"unit", "", "like"}
        table.add_column(heading, justify="left" if left else "right")
    for k, candidate in enumerate(ranked.candidates):
        _add_candidate(table, candidate, _likes(ranked, k))
    table.caption = (
        "p: chance that something in the catalogue looks as good when nothing is missing; like: "
        f"not told from this one by these shots (correlation above {SHOWN_ALIAS:g})"
    )
    console.print(table)


def explaining(campaign: Path, *, as_json: bool, folder: Path | None = None) -> None:
    """Go the whole way by itself: which effect is missing, none, or none that is known.

    Parameters
    ----------
    folder
        Where the user's own effects are. One with a fault is named and left out.

    Raises
    ------
    AnalysisInputError
        The campaign or the folder cannot be read.
    """
    known = available(folder)
    title, data = _gathered(campaign)
    with report.progress() as say:
        verdict, dropped = without_faulty(known.effects, lambda left: explain(data, left, say))
    faults = tell([*known.faults, *dropped])
    document = {**verdict_document(title, data, verdict), "faults": faults}
    if as_json:
        _print_json(document)
        return
    console = Console(width=TABLE_WIDTH)
    console.print(verdict_sentence(document), highlight=False)
    table = Table(title="error path", title_justify="left", box=None)
    for heading in ("with", "chi-squared per dof", "prediction error"):
        table.add_column(heading, justify="left" if heading == "with" else "right")
    for stage in document["path"]:
        name = ", ".join(stage["with"]) or "the base model"
        table.add_row(name, f"{stage['chi2_per_dof']:.4f}", f"{stage['prediction_error']:.4f}")
    table.caption = "prediction error: on shots left out, in units of the noise; 1 is the floor"
    console.print(table)
    for name, quantity in verdict.fit.parameters().items():
        unit = "" if quantity.unit == "1" else f" {quantity.unit}"
        console.print(f"{name} = {quantity.concise()}{unit}", highlight=False)
    if document["rejected"]:
        console.print(f"shots rejected: {document['rejected']}", highlight=False)


def _gathered(campaign: Path) -> tuple[str, PoseData]:
    try:
        return gather(campaign)
    except InputError as error:
        place = error.path if error.line is None else f"{error.path}, line {error.line}"
        raise AnalysisInputError(error.reason, part=place) from error


def _fitted(campaign: Path, names: Sequence[str], known: Available) -> tuple[str, PoseData, Fit]:
    added = [known.named(name, "--with") for name in names]
    title, poses = _gathered(campaign)
    data = without_contact_frames(poses)
    fitted = fit_campaign(data)
    try:
        for effect in added:
            fitted = fit_campaign(data, fitted.theory.with_effect(effect), fitted)
    except EffectFault as error:
        raise refused(error.fault) from error
    return title, data, fitted


def _headline(title: str, fitted: Fit) -> str:
    shots = len(fitted.shot_chi2)
    return (
        f"{title}: {shots} shots, chi-squared per degree of freedom {fitted.chi2_per_dof:.4f} "
        f"(sampling error {math.sqrt(2 / max(fitted.freedom, 1)):.4f})"
    )


def _fit_document(fitted: Fit, names: Sequence[str]) -> dict[str, Any]:
    return {
        "shots": len(fitted.shot_chi2),
        "with": list(names),
        "chi2_per_dof": fitted.chi2_per_dof,
        "degrees_of_freedom": fitted.freedom,
        "converged": fitted.converged,
        "parameters": {name: q.to_json() for name, q in fitted.parameters().items()},
    }


def _candidates_document(ranked: Ranking) -> list[dict[str, Any]]:
    return [
        {
            "effect": candidate.effect.name,
            "seen": candidate.seen,
            "score": candidate.score if candidate.seen else None,
            "promised_fall": candidate.fall,
            "p_value": candidate.p_value,
            "p_familywise": candidate.p_familywise,
            "plausible": candidate.plausible if candidate.seen else None,
            "amplitude": float(candidate.amplitudes[0]) if candidate.seen else None,
            "unit": candidate.effect.parameters[0].unit,
            "amplitudes": {
                parameter.symbol: Quantity(float(a), float(s), parameter.unit).to_json()
                for parameter, a, s in zip(
                    candidate.effect.parameters,
                    candidate.amplitudes,
                    candidate.sigmas,
                    strict=True,
                )
            }
            if candidate.seen
            else {},
            "like": _likes(ranked, k),
        }
        for k, candidate in enumerate(ranked.candidates)
    ]


def _likes(ranked: Ranking, k: int) -> list[str]:
    return [
        other.effect.name
        for j, other in enumerate(ranked.candidates)
        if j != k and ranked.aliases[k, j] > SHOWN_ALIAS
    ]


def _add_candidate(table: Table, candidate: Candidate, likes: list[str]) -> None:
    if not candidate.seen:
        table.add_row(candidate.effect.name, "", "", "", "cannot be seen with these shots")
        return
    parameter = candidate.effect.parameters[0]
    amplitude = Quantity(float(candidate.amplitudes[0]), float(candidate.sigmas[0]), parameter.unit)
    table.add_row(
        candidate.effect.name,
        f"{candidate.score:.1f}",
        f"{candidate.fall:.1f}",
        f"{candidate.p_familywise:.4f}",
        f"{parameter.symbol} = {amplitude.concise()}",
        "" if parameter.unit == "1" else parameter.unit,
        "" if candidate.plausible else "not plausible",
        ", ".join(likes),
    )


def _print_json(document: dict[str, Any]) -> None:
    print(json.dumps(document, allow_nan=False))  # noqa: T201
