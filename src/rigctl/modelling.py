"""What jobs compute of a campaign; each function is called in a process of its own.

Each takes one JSON object and a function that says how far it is, and returns a JSON object:
`campaign` is the title, `files` are pairs of a manifest and a result, `with` names effects.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import Effect
from analysis.model.fit import Fit, fit_campaign
from analysis.model.inside import without_contact_frames
from analysis.model.poses import PoseData
from analysis.model.ranking import rank
from analysis.model.report import candidates_document, verdict_document
from analysis.model.selection import explain
from rigctl.campaigns import MeasuredFiles, poses_from
from rigctl.errors import NotFoundError

Json = dict[str, Any]
Say = Callable[[str, float | None], None]


def request(title: str, files: Sequence[MeasuredFiles], effects: Sequence[str] = ()) -> Json:
    """Return the argument of the functions below."""
    listed = [{key: str(path) for key, path in asdict(own).items()} for own in files]
    return {"campaign": title, "files": listed, "with": list(effects)}


def require_effects(names: Sequence[str]) -> None:
    """Raise `NotFoundError`, which lists those there are, for a name that no effect has."""
    for name in names:
        effect_named(name)


def effect_named(name: str) -> Effect:
    """Return an effect of the catalogue; `NotFoundError`, if it has none, lists those it has."""
    known = {effect.name: effect for effect in CATALOGUE}
    if name not in known:
        raise NotFoundError(
            "no effect of the catalogue has this name",
            value=repr(name),
            todo=f"choose one of {', '.join(sorted(known))}",
        )
    return known[name]


def fit_job(asked: Json, say: Say) -> Json:
    """Fit the base model and the named effects."""
    _, fitted = _fitted(asked, say)
    return _fit_document(asked, fitted)


def ranking_job(asked: Json, say: Say) -> Json:
    """Fit the base model and the named effects, and rank what else the data ask for."""
    data, fitted = _fitted(asked, say)
    say("ranking the catalogue", None)
    ranked = rank(data, fitted, CATALOGUE)
    unseen = [each.effect.name for each in ranked.candidates if not each.seen]
    candidates = candidates_document(ranked)
    return {**_fit_document(asked, fitted), "candidates": candidates, "not_seen": unseen}


def explain_job(asked: Json, say: Say) -> Json:
    """Go the whole way to a verdict."""
    data = _poses(asked, say)
    verdict = explain(data, CATALOGUE, lambda text: say(text, None))
    return verdict_document(asked["campaign"], data, verdict)


def _poses(asked: Json, say: Say) -> PoseData:
    say("reading the poses", None)
    files = [MeasuredFiles(Path(own["manifest"]), Path(own["result"])) for own in asked["files"]]
    return poses_from(asked["campaign"], files)


def _fitted(asked: Json, say: Say) -> tuple[PoseData, Fit]:
    data = without_contact_frames(_poses(asked, say))
    say("fitting the base model", None)
    fitted = fit_campaign(data)
    for name in asked["with"]:
        say(f"adding {name}", None)
        fitted = fit_campaign(data, fitted.theory.with_effect(effect_named(name)), fitted)
    return data, fitted


def _fit_document(asked: Json, fitted: Fit) -> Json:
    return {
        "campaign": asked["campaign"],
        "shots": len(fitted.shot_chi2),
        "with": asked["with"],
        "chi2_per_dof": fitted.chi2_per_dof,
        "degrees_of_freedom": fitted.freedom,
        "converged": fitted.converged,
        "parameters": {name: q.to_json() for name, q in fitted.parameters().items()},
    }
