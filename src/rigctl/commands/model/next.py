"""`rigctl model next`: the shots that tell two effects apart, or sharpen a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from analysis.effects.effect import Effect
from analysis.effects.own.fault import EffectFault
from analysis.errors import LaunchRefusedError
from analysis.launch.fit import fit_launch
from analysis.launch.prediction import Limits
from analysis.model.design.between import PROBABILITY, tell_apart
from analysis.model.design.candidates import grid
from analysis.model.design.document import NONE, sharpening_document, telling_document
from analysis.model.design.sharpen import sharpen
from analysis.model.design.undecided import fired_alike, next_after
from analysis.model.judged import judged
from analysis.model.poses import PoseData
from analysis.model.selection import explain
from rigctl.campaigns import open_campaign
from rigctl.commands import report
from rigctl.commands.effect import Available, available, refused, tell
from rigctl.commands.model.printing import TABLE_WIDTH, print_json
from rigctl.config import load
from rigctl.errors import AnalysisInputError, NotFoundError, SettingsError
from rigctl.sweeps.form import Sweep
from rigctl.sweeps.writing import write_sweep

Json = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Question:
    """What next shots are to be good for.

    Attributes
    ----------
    between
        Names of two effects, or `none`; None: the alias set of the verdict.
    sharpen, to
        A parameter in place of effects, and the standard error to reach, in its unit.
    names
        Effects that are believed already.
    probability
        Of naming the right one of two effects.
    """

    between: tuple[str, str] | None = None
    sharpen: str | None = None
    to: float | None = None
    names: tuple[str, ...] = ()
    probability: float = PROBABILITY

    def check(self) -> None:
        """Refuse what contradicts itself.

        Raises
        ------
        SettingsError
            Two questions at once, an effect against itself, or an error to reach of nothing.
        """
        if self.between is not None and self.sharpen is not None:
            raise SettingsError(
                "two questions at once", part="--sharpen", todo="ask --between or --sharpen"
            )
        if self.to is not None and self.sharpen is None:
            raise SettingsError(
                "belongs to a parameter", part="--to", todo="name one with --sharpen"
            )
        if self.between is not None and self.between[0] == self.between[1]:
            raise SettingsError(
                "names one thing twice",
                part="--between",
                value=repr(self.between[0]),
                todo=f"name two effects, or one and {NONE}",
            )
        twice = sorted({*(self.between or ())} & {*self.names})
        if twice:
            raise SettingsError(
                "stands among the effects that are believed already",
                part="--between",
                value=repr(twice[0]),
                todo="leave it out of --with",
            )


def next_shots(
    campaign: Path,
    question: Question,
    *,
    as_json: bool,
    folder: Path | None = None,
    out: Path | None = None,
    configuration: Path | None = None,
) -> None:
    """Choose the next shots of a campaign within the rig's limits; print them, or write a sweep.

    Parameters
    ----------
    folder
        Where the user's own effects are.
    out
        Sweep file to write.
    configuration
        Of the rig that is to fire them; None: the simulated rig.

    Raises
    ------
    AnalysisInputError
        The campaign cannot be read, holds no poses or no settings, or an effect has a fault.
    NotFoundError
        No effect or parameter has that name, or the verdict leaves nothing to tell apart.
    SettingsError
        The question contradicts itself.
    ConfigurationError, StoreError
        The configuration cannot be read, or the sweep file cannot be written.
    """
    question.check()
    known = available(folder)
    rig = load(configuration).limits
    limits = Limits(rig.pressure_kpa, rig.offset_mm)
    title, data = open_campaign(campaign, configuration, poses=True)
    if not isinstance(data, PoseData):
        raise AnalysisInputError(
            "tabulated contacts do not say what a shot elsewhere would show",
            part=title,
            todo="give its poses",
        )
    try:
        with report.progress() as say:
            say("choosing shots")
            document = {"campaign": title, **answer(data, question, known, limits)}
    except EffectFault as error:
        raise refused(error.fault) from error
    except LaunchRefusedError as error:
        raise AnalysisInputError(f"no shot can be foretold: {error}", part=title) from error
    document["faults"] = tell(known.faults)
    if out is not None:
        write_sweep(out, sweep_of(document))
    if as_json:
        print_json(document)
    else:
        _print(document, out)


def answer(data: PoseData, question: Question, known: Available, limits: Limits) -> Json:
    """Return the document of the next shots, but for the campaign's name.

    Raises
    ------
    NotFoundError
        No effect or parameter has that name, or the verdict leaves nothing to tell apart.
    LaunchRefusedError
        The settings of the campaign do not let shots be foretold.
    EffectFault
        An effect of the user's own fails.
    """
    if question.between is None and question.sharpen is None:
        return _undecided(data, known, limits)
    believed = [known.named(name, "--with") for name in question.names]
    pair = [_effect(name, known) for name in question.between or ()]
    found = judged(data, believed)
    if not isinstance(found.data, PoseData):
        raise TypeError("poses were judged and are poses no more")
    launch = fit_launch(found.data, found.fit)
    settings = grid(limits, alike=fired_alike(data))
    if question.sharpen is not None:
        _require_parameter(question.sharpen, found.fit.theory.names)
        sharper = sharpen(
            found.data, found.fit, launch, question.sharpen, settings, target=question.to
        )
        return sharpening_document(sharper)
    told = tell_apart(
        found.data,
        found.fit,
        launch,
        (pair[0], pair[1]),
        settings,
        probability=question.probability,
    )
    return telling_document(told)


def sweep_of(document: Json) -> Sweep:
    """Return the next shots as a sweep, to be fired in a drawn order.

    Raises
    ------
    NotFoundError
        There is none to fire.
    """
    if not document["next_shots"]:
        raise NotFoundError(
            "no shots are needed", part="--out", todo="read the answer without --out"
        )
    if "sharpen" in document:
        note = f"sharpens {document['sharpen']} of {document['campaign']}"
    else:
        note = f"tells {' from '.join(document['between'])} after {document['campaign']}"
    return Sweep.model_validate({"note": note, "shots": document["next_shots"]})


def _undecided(data: PoseData, known: Available, limits: Limits) -> Json:
    told = next_after(explain(data, known.effects), known.effects, limits)
    if told is None:
        raise NotFoundError(
            "the verdict leaves no effects to tell apart",
            todo="name two with --between, or a parameter with --sharpen",
        )
    return telling_document(told)


def _effect(name: str, known: Available) -> Effect | None:
    return None if name == NONE else known.named(name, "--between")


def _require_parameter(name: str, names: Sequence[str]) -> None:
    if name not in names:
        raise NotFoundError(
            "the fit has no parameter of this name",
            part="--sharpen",
            value=repr(name),
            todo=f"choose one of {', '.join(names)}; effects are added with --with",
        )


def _print(document: Json, out: Path | None) -> None:
    console = Console(width=TABLE_WIDTH)
    console.print(sentence(document), highlight=False)
    table = Table(box=None)
    for heading in ("pressure a, kPa", "pressure b, kPa", "offset, mm", "shots"):
        table.add_column(heading, justify="right")
    for shot in document["next_shots"]:
        numbers = (shot["pressure_a_kpa"], shot["pressure_b_kpa"], shot["offset_mm"])
        table.add_row(*(f"{number:g}" for number in numbers), str(shot["repeat"]))
    if document["next_shots"]:
        console.print(table)
    if out is not None:
        console.print(f"{out}: fire it with rigctl sweep {out}", highlight=False)


def sentence(document: Json) -> str:
    """Say in words what the next shots do."""
    name, count = document["campaign"], document["shots"]
    shots = "1 shot" if count == 1 else f"{count} shots"
    even = document["even_shots"]
    spread = f"{even} spread evenly" if even is not None else "more than 5000 spread evenly"
    if "sharpen" in document:
        unit = "" if document["unit"] == "1" else f" {document['unit']}"
        goal = (
            f"bring the standard error of {document['sharpen']} from "
            f"{document['sigma_without']:.3g} to {document['sigma']:.3g}{unit}"
        )
    else:
        one, other = document["between"]
        goal = (
            f"tell {one} from {other} with probability {document['probability']:.2f}; the campaign "
            f"alone {document['probability_without']:.2f}"
        )
    if not count:
        return f"{name}: no more shots are needed to {goal}."
    short = "" if document["enough"] else ", less than was asked for"
    return f"{name}: {shots}, or {spread}, {goal}{short}."
