"""`rigctl model`: a campaign against the model."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rigctl.command_line.options import Config, Json, OwnEffects

model = typer.Typer(help="Compare a campaign with the model; find the effect it lacks.")

Campaign = Annotated[
    Path, typer.Argument(help="Campaign folder, or a campaign's name in the store.")
]
With = Annotated[
    list[str] | None,
    typer.Option("--with", help="Add this effect of the catalogue; may be given several times."),
]
Streamed = Annotated[
    bool,
    typer.Option("--stream", help="Go over poses.csv in parts: memory for any number of shots."),
]
Pictures = Annotated[
    Path | None, typer.Option("--out", help="Write pictures (PNG and SVG) into this folder.")
]


@model.command("agreement")
def model_agreement(
    campaign: Campaign,
    *,
    effects: With = None,
    folder: OwnEffects = None,
    out: Pictures = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Say where the model and the campaign agree, and where they do not."""
    from rigctl.commands.model.agreement import agreement

    wanted = effects or []
    found = agreement(campaign, wanted, as_json=json, folder=folder, configuration=config)
    if out is not None:
        from rigctl.commands.model.pictures import draw_agreement

        _say_written(draw_agreement(out, found))


@model.command("fit")
def model_fit(
    campaign: Campaign,
    *,
    effects: With = None,
    folder: OwnEffects = None,
    stream: Streamed = False,
    config: Config = None,
    json: Json = False,
) -> None:
    """Fit e, mu, beta0 and the effects added to all poses of a campaign."""
    from rigctl.commands.model.fit import fit

    fit(
        campaign,
        effects or [],
        as_json=json,
        folder=folder,
        configuration=config,
        stream=stream,
    )


@model.command("rank")
def model_rank(
    campaign: Campaign,
    *,
    effects: With = None,
    folder: OwnEffects = None,
    out: Pictures = None,
    stream: Streamed = False,
    config: Config = None,
    json: Json = False,
) -> None:
    """Rank the effects of the catalogue by what they promise."""
    from rigctl.commands.model.rank import ranking

    found = ranking(
        campaign,
        effects or [],
        as_json=json,
        folder=folder,
        configuration=config,
        stream=stream,
    )
    if out is not None:
        from rigctl.commands.model.pictures import draw_ranking

        _say_written(draw_ranking(out, *found))


@model.command("launch")
def model_launch(
    campaign: Campaign, *, effects: With = None, config: Config = None, json: Json = False
) -> None:
    """Fit the launches from the settings, and rank the effects of the launch."""
    from rigctl.commands.model.launch import launch

    launch(campaign, effects or [], as_json=json, configuration=config)


@model.command("explain")
def model_explain(
    campaign: Campaign,
    *,
    folder: OwnEffects = None,
    out: Pictures = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Find what is missing, add it, and say how much of the error it removes."""
    from rigctl.commands.model.explain import explaining

    found = explaining(campaign, as_json=json, folder=folder, configuration=config)
    if out is not None:
        from rigctl.commands.model.pictures import draw_explanation

        _say_written(draw_explanation(out, *found))


@model.command("next")
def model_next(
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
    """Choose the next shots: to tell two effects apart, or to sharpen a parameter."""
    from rigctl.commands.model.next import next_shots
    from rigctl.model.next_shots import Question

    next_shots(
        campaign,
        Question(between, sharpen, to, tuple(effects or ()), probability),
        as_json=json,
        folder=folder,
        out=out,
        configuration=config,
    )


def _say_written(paths: list[Path]) -> None:
    for path in paths:
        typer.echo(f"{path}", err=True)
