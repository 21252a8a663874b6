"""`rigctl model next`: the shots that tell two effects apart, or sharpen a parameter."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from analysis.effects.own.fault import EffectFault
from analysis.errors import LaunchRefusedError
from analysis.launch.prediction import Limits
from rigctl.cli.model.reading import report_faults
from rigctl.cli.options import Campaign, Config, Json, OwnEffects, With
from rigctl.cli.output import TABLE_WIDTH, print_json, progress
from rigctl.config import load
from rigctl.errors import AnalysisInputError
from rigctl.model.campaigns import open_campaign
from rigctl.model.known_effects import available, refused
from rigctl.model.next_shots import Known, Question, answer
from rigctl.model.next_words import sentence, sweep_of
from rigctl.model.tabulated_campaigns import require_poses
from rigctl.sweeps.form import write_sweep


def next_shots(
    campaign: Campaign,
    *,
    between: Annotated[
        tuple[str, str] | None,
        typer.Option(help="Two effects to tell apart; none is the base model."),
    ] = None,
    sharpen: Annotated[
        str | None, typer.Option(help="A parameter to make surer: e, mu, beta0, effect.symbol.")
    ] = None,
    to: Annotated[
        float | None,
        typer.Option(min=1e-12, help="Its standard error to reach; without it half of what it is."),
    ] = None,
    probability: Annotated[
        float, typer.Option(min=0.55, max=0.999, help="Of naming the right one of two.")
    ] = 0.9,
    effects: With = None,
    folder: OwnEffects = None,
    out: Annotated[Path | None, typer.Option(help="Write the shots as a sweep file.")] = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Choose the next shots of a campaign within the rig's limits; print them, or write a sweep.

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
    question = Question(between, sharpen, to, tuple(effects or ()), probability)
    question.check()
    known = available(folder)
    choice = Known(known.effects, lambda name: known.named(name, "EFFECT"))
    rig = load(config).limits
    limits = Limits(rig.pressure_kpa, rig.offset_mm)
    title, found = open_campaign(campaign, config, poses=True)
    data = require_poses(title, found)
    try:
        with progress() as report:
            report("choosing shots")
            document = {"campaign": title, **answer(data, question, choice, limits)}
    except EffectFault as error:
        raise refused(error.fault) from error
    except LaunchRefusedError as error:
        raise AnalysisInputError(f"no shot can be foretold: {error}", part=title) from error
    document["faults"] = report_faults(known.faults)
    if out is not None:
        write_sweep(out, sweep_of(document))
    if json:
        print_json(document)
    else:
        _print(document, out)


def _print(document: dict[str, Any], out: Path | None) -> None:
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
