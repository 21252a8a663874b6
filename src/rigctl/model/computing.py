"""What jobs compute of a campaign; each function is called in a process of its own.

Each takes one JSON object and a function that says how far it is, and returns a JSON object:
`campaign` is the title, `files` are pairs of a manifest and a result, `with` names effects; where
`shots_of` names more of them, the fit is of those shots that the model with all of them uses. A
`folder` in the place of `files` is a campaign's folder. `store` and `database` say where the
catalogue is: the tables of a campaign that came without poses are found there. `own`, where it is
there, is a folder of effects of the user's own; those that cannot be used are named in the answer
under `faults`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from numba.core import registry

from analysis.effects.own.dropping import without_faulty
from analysis.effects.own.fault import Fault
from analysis.errors import LaunchRefusedError
from analysis.launch.prediction import Limits
from analysis.model.agreement.agree import agree
from analysis.model.agreement.document import (
    agreement_document,
    cells_document,
    findings_document,
    structure_document,
)
from analysis.model.agreement.freed import paths_document
from analysis.model.agreement.launch import launch_stage
from analysis.model.agreement.table import Stage
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import whole
from analysis.model.data.tables import Data
from analysis.model.design.undecided import explain_with_next
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.robust_fit import on_shots_of, robust_fit
from analysis.model.plane import impact_plane
from analysis.model.proposals.document import confirmation_document
from analysis.model.proposals.stated import Statement
from analysis.model.rank.ranking import rank
from analysis.model.structure.structure import structure
from analysis.model.verdict.documents import fit_document, ranking_document, verdict_document
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.input_errors import as_analysis_errors
from rigctl.measuring.measured import MeasuredFiles
from rigctl.model.campaigns import folder_data, poses_from
from rigctl.model.known_effects import Available, available, faults_refused
from rigctl.model.next_shots import Known, Question, answer
from rigctl.model.own_effects import PART
from rigctl.model.proposing import confirmed_statement, proposed_laws, shared_laws
from rigctl.model.seen_effects import require_seen
from rigctl.model.tabulated_campaigns import is_tabulated, require_poses, tabulated
from rigctl.progress import Progress
from rigctl.store import reading


def prepare() -> None:
    """Have ready what a fit begins with, in a process that waits for its order.

    Machine code that is taken from the cache needs tables of all operations: a fifth of a second.
    """
    # The compiler's library has no hints of types.
    target = cast("Any", registry.cpu_target)
    target.typing_context.refresh()
    target.target_context.refresh()


def fit_job(asked: Json, progress: Progress) -> Json:
    """Fit the base model and the named effects."""
    found = _fitted(asked, progress)
    return {**found.document, "faults": found.faults()}


def ranking_job(asked: Json, progress: Progress) -> Json:
    """Fit the base model and the named effects, and rank what else the data ask for."""
    found = _fitted(asked, progress)
    progress("ranking the effects", None)
    return {**found.document, **_ranked(found)}


def agreement_job(asked: Json, progress: Progress) -> Json:
    """Fit the base model and the named effects, and say by stage where they agree."""
    found = _fitted(asked, progress)
    progress("comparing", None)
    return {**found.document, **_compared(found.data, found.fit), "faults": found.faults()}


def structure_job(asked: Json, progress: Progress) -> Json:
    """Fit the base model and the named effects, and test what they leave over."""
    found = _fitted(asked, progress)
    progress("testing what is left", None)
    tested = structure_document(structure(found.data, found.fit))
    return {**found.document, "structure": tested, "faults": found.faults()}


def explain_job(asked: Json, progress: Progress) -> Json:
    """Go the whole way to a verdict."""
    known = _known(asked)
    data = _data(asked, progress)
    (verdict, following), dropped = without_faulty(
        known.effects,
        lambda left: explain_with_next(data, left, lambda text: progress(text, None)),
    )
    document = verdict_document(asked["campaign"], data, verdict, following)
    return {**document, "faults": _told(known, dropped)}


def propose_job(asked: Json, progress: Progress) -> Json:
    """Propose the law that no catalogue holds, beside the named effects; `limits` are the rig's.

    `together` holds the files of further campaigns: what do all share? `confirm` states one form,
    which is tested on the shots that it was not chosen on.
    """
    known = _known(asked)
    given = [known.named(name) for name in asked["with"]]
    data = _data(asked, progress)
    if asked.get("together"):
        further = [(one["campaign"], _data(one, progress)) for one in asked["together"]]
        progress("scoring forms in all campaigns", None)
        with faults_refused():
            document = shared_laws([(asked["campaign"], data), *further], given)
        return {**document, "faults": _told(known)}
    if asked.get("confirm") is not None:
        progress("testing the form", None)
        stated = Statement.read(asked["confirm"])
        with faults_refused():
            tested = confirmed_statement(asked["campaign"], data, given, stated)
        return {**confirmation_document(asked["campaign"], tested), "faults": _told(known)}
    pressure, offset = asked["limits"]
    limits = Limits((pressure[0], pressure[1]), (offset[0], offset[1]))
    with faults_refused():
        require_seen(data, given, "with")
        (_, document), dropped = without_faulty(
            known.effects,
            lambda left: proposed_laws(
                asked["campaign"],
                data,
                given,
                left,
                report=lambda text: progress(text, None),
                limits=limits,
            ),
        )
    return {**document, "faults": _told(known, dropped)}


def next_job(asked: Json, progress: Progress) -> Json:
    """Choose next shots; `between`, `sharpen`, `to`, `probability` and `limits` stand beside."""
    known = _known(asked)
    data = require_poses(asked["campaign"], _data(asked, progress))
    question = Question(
        between=None if asked["between"] is None else (asked["between"][0], asked["between"][1]),
        sharpen=asked["sharpen"],
        to=asked["to"],
        names=tuple(asked["with"]),
        probability=asked["probability"],
    )
    question.check()
    progress("choosing shots", None)
    pressure, offset = asked["limits"]
    limits = Limits((pressure[0], pressure[1]), (offset[0], offset[1]))
    try:
        with faults_refused():
            found = answer(data, question, Known(known.effects, known.named), limits)
    except LaunchRefusedError as error:
        raise AnalysisInputError(
            f"no shot can be foretold: {error}", part=asked["campaign"]
        ) from error
    return {"campaign": asked["campaign"], **found, "faults": _told(known)}


def picture_job(asked: Json, progress: Progress) -> Json:
    """Fit, and answer all that can be asked of one fit: agreement, structure, ranking, figure 7.4.

    Beside them `paths`: some shots as they were measured and as the model predicts them, and
    `estimated`: whether errors were not stated, so that the scatter about this fit stands for them.
    """
    found = _fitted(asked, progress)
    progress("comparing", 0.3)
    compared = _compared(found.data, found.fit)
    progress("testing what is left", 0.5)
    left = structure(found.data, found.fit)
    tested = {"cells": cells_document(left), "findings": findings_document(left)}
    paths = paths_document(found.data, found.fit)
    progress("ranking the effects", 0.7)
    ranked = _ranked(found)
    plane = impact_plane(found.data, found.fit).to_json()
    answers = {**compared, **tested, "paths": paths, **ranked, "plane": plane}
    if isinstance(found.data, PoseData) and found.data.on_plate:
        about_a_plate(answers)
    return {**found.document, **answers, "estimated": found.data.estimated}


def about_a_plate(answer: object) -> None:
    """Note in each row, cell and film of an answer that one sphere meets a plate, as `on_plate`."""
    if isinstance(answer, dict):
        if not answer.keys().isdisjoint(("quantity", "channel", "radii_mm")):
            answer["on_plate"] = True
        for part in answer.values():
            about_a_plate(part)
    elif isinstance(answer, list | tuple):
        for part in answer:
            about_a_plate(part)


def path_job(asked: Json, progress: Progress) -> Json:
    """Return the path of one `shot`, by its number, measured and as the model predicts it.

    `paths` is empty where the fit left the shot out, and of tables.
    """
    found = _fitted(asked, progress)
    paths = paths_document(found.data, found.fit, int(asked["shot"]))
    if isinstance(found.data, PoseData) and found.data.on_plate:
        about_a_plate(paths)
    return {"paths": paths}


@dataclass(frozen=True, slots=True, eq=False)
class _Fitted:
    """A fit, the document of it, and the effects there are."""

    known: Available
    data: Data
    fit: Fit
    document: Json

    def faults(self, dropped: Sequence[Fault] = ()) -> list[Json]:
        return _told(self.known, dropped)


def _ranked(found: _Fitted) -> Json:
    """Rank all effects alike; `own` is what those of the user's say of themselves."""
    with faults_refused():
        ranked, dropped = without_faulty(
            found.known.effects, lambda effects: rank(found.data, found.fit, effects)
        )
    return {
        "candidates": ranking_document(ranked),
        "own": found.known.own(),
        "faults": found.faults(dropped),
    }


def _told(known: Available, dropped: Sequence[Fault] = ()) -> list[Json]:
    return [fault.to_json() for fault in (*known.faults, *dropped)]


def _compared(data: Data, fitted: Fit) -> Json:
    """Compare by stage, the launch first; `launch_left_out` says why where there is none."""
    launch, refused = list[Stage](), None
    try:
        launch.append(launch_stage(data, fitted))
    except LaunchRefusedError as error:
        refused = str(error)
    return {**agreement_document(agree(data, fitted, launch)), "launch_left_out": refused}


def _data(asked: Json, progress: Progress) -> Data:
    progress("reading the poses", None)
    if "folder" in asked:
        return folder_data(Path(asked["folder"]))[1]
    if "store" in asked:
        with reading(Path(asked["store"]), asked["database"]) as store, as_analysis_errors():
            if is_tabulated(store, asked["campaign"]):
                return tabulated(store, asked["campaign"])
    files = [
        MeasuredFiles(Path(own["manifest"]), Path(own["result"]), bool(own["excluded"]))
        for own in asked["files"]
    ]
    return poses_from(asked["campaign"], files)


def _known(asked: Json) -> Available:
    return available(Path(asked["own"]) if "own" in asked else None, PART)


def _fitted(asked: Json, progress: Progress) -> _Fitted:
    known = _known(asked)
    added = [known.named(name) for name in asked["with"]]
    data = _data(asked, progress)
    progress(f"fitting {', '.join(['the base model', *asked['with']])}", None)
    later = [known.named(name) for name in asked.get("shots_of", ())]
    with faults_refused():
        require_seen(data, [*added, *later], "with")
        found = robust_fit(data, added)
        if later:
            found = on_shots_of(found, robust_fit(data, later))
    document = fit_document(asked["campaign"], asked["with"], found)
    return _Fitted(known, whole(found.data), found.fit, document)
