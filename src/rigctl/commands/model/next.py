"""`rigctl model next`: the shots that tell two effects apart, or sharpen a parameter."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from analysis.effects.own.fault import EffectFault
from analysis.errors import LaunchRefusedError
from analysis.launch.prediction import Limits
from analysis.model.poses import PoseData
from rigctl.campaigns import open_campaign
from rigctl.commands import report
from rigctl.commands.effect import available, refused, tell
from rigctl.commands.model.printing import TABLE_WIDTH, print_json
from rigctl.config import load
from rigctl.errors import AnalysisInputError, NotFoundError
from rigctl.next_shots import Known, Question, answer
from rigctl.sweeps.form import Sweep
from rigctl.sweeps.writing import write_sweep

Json = dict[str, Any]


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
    choice = Known(known.effects, lambda name: known.named(name, "EFFECT"))
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
            document = {"campaign": title, **answer(data, question, choice, limits)}
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
    count, even = document["shots"], document["even_shots"]
    shots = "1 shot" if count == 1 else f"{count} shots"
    spread = f"{even} spread evenly" if even is not None else "more than 5000 spread evenly"
    needed = f"{shots} (or {spread})" if count else "the campaign alone"
    short = "" if document["enough"] else ", less than was asked for"
    return f"{document['campaign']}: {needed} {_deed(document, plural=count > 1)}{short}."


def _deed(document: Json, *, plural: bool) -> str:
    if "sharpen" in document:
        verb = "bring" if plural else "brings"
        unit = "" if document["unit"] == "1" else f" {document['unit']}"
        return (
            f"{verb} the standard error of {document['sharpen']} from "
            f"{document['sigma_without']:.3g} to {document['sigma']:.3g}{unit}"
        )
    verb, (one, other) = "tell" if plural else "tells", document["between"]
    return (
        f"{verb} {one} from {other} with probability {document['probability']:.2f}, up from "
        f"{document['probability_without']:.2f}"
    )
