"""What jobs compute of a campaign; each function is called in a process of its own.

Each takes one JSON object and a function that says how far it is, and returns a JSON object:
`campaign` is the title, `files` are pairs of a manifest and a result, `with` names effects; a
`folder` in the place of `files` is a campaign's folder.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from analysis.effects.catalogue import CATALOGUE
from analysis.errors import LaunchRefusedError
from analysis.launch.prediction import Limits
from analysis.model.agreement.agree import agree
from analysis.model.agreement.document import (
    agreement_document,
    cells_document,
    structure_document,
)
from analysis.model.agreement.launch import launch_stage
from analysis.model.agreement.table import Stage
from analysis.model.design.undecided import next_after
from analysis.model.documents import fit_document, ranking_document
from analysis.model.fit import Fit
from analysis.model.judged import judged
from analysis.model.plane import impact_plane
from analysis.model.poses import PoseData
from analysis.model.ranking import rank
from analysis.model.report import verdict_document
from analysis.model.selection import explain
from analysis.model.structure import structure
from analysis.model.tables import Data
from rigctl.campaigns import folder_poses, poses_from
from rigctl.errors import AnalysisInputError
from rigctl.known_effects import effect_named
from rigctl.measured import MeasuredFiles
from rigctl.next_shots import Known, Question, answer

Json = dict[str, Any]
Say = Callable[[str, float | None], None]


def fit_job(asked: Json, say: Say) -> Json:
    """Fit the base model and the named effects."""
    return _fitted(asked, say)[2]


def ranking_job(asked: Json, say: Say) -> Json:
    """Fit the base model and the named effects, and rank what else the data ask for."""
    data, fitted, document = _fitted(asked, say)
    say("ranking the catalogue", None)
    return {**document, "candidates": ranking_document(rank(data, fitted, CATALOGUE))}


def agreement_job(asked: Json, say: Say) -> Json:
    """Fit the base model and the named effects, and say by stage where they agree."""
    data, fitted, document = _fitted(asked, say)
    say("comparing", None)
    return {**document, **_compared(data, fitted)}


def structure_job(asked: Json, say: Say) -> Json:
    """Fit the base model and the named effects, and test what they leave over."""
    data, fitted, document = _fitted(asked, say)
    say("testing what is left", None)
    return {**document, "structure": structure_document(structure(data, fitted))}


def explain_job(asked: Json, say: Say) -> Json:
    """Go the whole way to a verdict."""
    data = _poses(asked, say)
    verdict = explain(data, CATALOGUE, lambda text: say(text, None))
    say("choosing shots", None)
    return verdict_document(asked["campaign"], data, verdict, next_after(verdict, CATALOGUE))


def next_job(asked: Json, say: Say) -> Json:
    """Choose next shots; `between`, `sharpen`, `to`, `probability` and `limits` stand beside."""
    data = _poses(asked, say)
    question = Question(
        between=None if asked["between"] is None else (asked["between"][0], asked["between"][1]),
        sharpen=asked["sharpen"],
        to=asked["to"],
        names=tuple(asked["with"]),
        probability=asked["probability"],
    )
    question.check()
    say("choosing shots", None)
    pressure, offset = asked["limits"]
    limits = Limits((pressure[0], pressure[1]), (offset[0], offset[1]))
    try:
        found = answer(data, question, Known(CATALOGUE, effect_named), limits)
    except LaunchRefusedError as error:
        raise AnalysisInputError(
            f"no shot can be foretold: {error}", part=asked["campaign"]
        ) from error
    return {"campaign": asked["campaign"], **found}


def picture_job(asked: Json, say: Say) -> Json:
    """Fit, and answer all that can be asked of one fit: agreement, structure, ranking, figure 7.4.

    The points of each cell are a text of JSON in the document, to be parsed when it is looked at.
    """
    data, fitted, document = _fitted(asked, say)
    say("comparing", 0.3)
    compared = _compared(data, fitted)
    say("testing what is left", 0.5)
    cells = cells_document(structure(data, fitted))
    say("ranking the catalogue", 0.7)
    candidates = ranking_document(rank(data, fitted, CATALOGUE))
    plane = impact_plane(data, fitted).to_json()
    return {**document, **compared, "cells": cells, "candidates": candidates, "plane": plane}


def _compared(data: Data, fitted: Fit) -> Json:
    """Compare by stage, the launch first; `launch_left_out` says why where there is none."""
    launch, refused = list[Stage](), None
    try:
        launch.append(launch_stage(data, fitted))
    except LaunchRefusedError as error:
        refused = str(error)
    return {**agreement_document(agree(data, fitted, launch)), "launch_left_out": refused}


def _poses(asked: Json, say: Say) -> PoseData:
    say("reading the poses", None)
    if "folder" in asked:
        return folder_poses(Path(asked["folder"]))[1]
    files = [
        MeasuredFiles(Path(own["manifest"]), Path(own["result"]), bool(own["excluded"]))
        for own in asked["files"]
    ]
    return poses_from(asked["campaign"], files)


def _fitted(asked: Json, say: Say) -> tuple[Data, Fit, Json]:
    poses = _poses(asked, say)
    say(f"fitting {', '.join(['the base model', *asked['with']])}", None)
    found = judged(poses, [effect_named(name) for name in asked["with"]])
    return found.data, found.fit, fit_document(asked["campaign"], asked["with"], found)
