"""The commands; each loads what it needs when it runs, so that --help answers at once."""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from typer.exceptions import TyperException

from rigctl.errors import (
    AnalysisInputError,
    ConfigurationError,
    DeviceError,
    NotFoundError,
    RecordingNotConfirmedError,
    RefusedError,
    RigError,
    SettingsError,
    StoreError,
)

BAD_INPUT, REFUSED, NOT_FOUND = 2, 3, 4

_EXIT_CODES: tuple[tuple[type[RigError], int], ...] = (
    (NotFoundError, NOT_FOUND),
    (RefusedError, REFUSED),
    (DeviceError, REFUSED),
    (RecordingNotConfirmedError, REFUSED),
    (StoreError, REFUSED),
    (AnalysisInputError, BAD_INPUT),
    (ConfigurationError, BAD_INPUT),
    (SettingsError, BAD_INPUT),
)

app = typer.Typer(
    name="rigctl",
    help="A collision laboratory: fire the rig, film two spheres, measure the impact.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Config = Annotated[
    Path | None,
    typer.Option("--config", help="Configuration of the rig (TOML); without it all is simulated."),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on standard output.")]


class Method(StrEnum):
    """How images are measured."""

    THESIS = "thesis"
    PHOTOMETRIC = "photometric"


class MarkerMatching(StrEnum):
    """How markers are matched from frame to frame."""

    PATTERN = "pattern"
    PROXIMAL = "proximal"


@app.callback()
def rigctl() -> None:
    """Keep the commands a group, however many there are."""


@app.command()
def serve(
    *,
    config: Config = None,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="Listen here instead; 0 takes any free port."),
    ] = None,
    key: Annotated[
        str | None,
        typer.Option(envvar="RIGCTL_KEY", help="Key of the service; without it a fresh one."),
    ] = None,
) -> None:
    """Run the daemon: REST on 127.0.0.1:8486, the simulated rig by default."""
    from rigctl.commands.serve import serve as run_daemon

    run_daemon(config, port, key)


@app.command()
def shot(
    *,
    pressure_kpa: Annotated[float, typer.Option(help="Gauge pressure of pusher a in kPa.")],
    offset_mm: Annotated[float, typer.Option(help="Vertical offset of tube b below a in mm.")],
    pressure_b_kpa: Annotated[
        float | None, typer.Option(help="Gauge pressure of pusher b in kPa; as a without it.")
    ] = None,
    delay_us: Annotated[
        float, typer.Option(help="Pusher b fires this much later, microseconds.")
    ] = 0.0,
    angle_a_deg: Annotated[
        float | None, typer.Option(help="Tilt of tube a in degrees; release apparatus only.")
    ] = None,
    angle_b_deg: Annotated[
        float | None, typer.Option(help="Tilt of tube b in degrees; release apparatus only.")
    ] = None,
    campaign: Annotated[str | None, typer.Option(help="Campaign the shot belongs to.")] = None,
    local: Annotated[bool, typer.Option("--local", help="Fire without a daemon.")] = False,
    wait_s: Annotated[
        float, typer.Option(min=0.0, max=3600.0, help="Longest wait for the measurement, s.")
    ] = 120.0,
    config: Config = None,
    key: Annotated[
        str | None,
        typer.Option(
            envvar="RIGCTL_KEY", help="Key of the daemon; without it from the store's key file."
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Fire one shot and print its coefficients."""
    from rigctl.commands.shot import Order, settings_of
    from rigctl.commands.shot import shot as fire

    settings = settings_of(
        pressure_a_kpa=pressure_kpa,
        pressure_b_kpa=pressure_kpa if pressure_b_kpa is None else pressure_b_kpa,
        offset_mm=offset_mm,
        delay_us=delay_us,
        angle_a_deg=angle_a_deg,
        angle_b_deg=angle_b_deg,
    )
    order = Order(settings, campaign, wait_s)
    if local:
        from rigctl.commands.local import opened

        fire(order, opened(config), as_json=json)
    else:
        from rigctl.commands.client import connected

        fire(order, connected(config, key), as_json=json)


@app.command()
def demo(
    out: Annotated[
        Path, typer.Option(help="Folder for the frames, results and the picture.")
    ] = Path("out"),
) -> None:
    """Fire a small sweep on a simulated rig and set measured beside true; no daemon needed."""
    from rigctl.commands.demo import demo as run_demo

    run_demo(out)


@app.command()
def analyse(
    paths: Annotated[
        list[Path], typer.Argument(help="Campaign folders, or frames: TIFF, NPY, AVI, PNG folder.")
    ],
    *,
    method: Annotated[Method, typer.Option(help="How images are measured.")] = Method.THESIS,
    setup: Annotated[
        Path | None,
        typer.Option(help="A campaign.toml for frames that belong to no campaign folder."),
    ] = None,
    sigma_px: Annotated[
        float | None,
        typer.Option(min=0.5, max=8.0, help="Width of the edge filter in pixels; thesis: 2."),
    ] = None,
    samples: Annotated[
        int | None,
        typer.Option(min=1, max=16, help="Facet samples a pixel; thesis: 3 or 4. Default: exact."),
    ] = None,
    matching: Annotated[
        MarkerMatching, typer.Option(help="Markers by rigid pattern, or frame to frame.")
    ] = MarkerMatching.PATTERN,
    three: Annotated[
        bool, typer.Option("--three", help="Three frames before and three after, 2 ms apart.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="Write an exchange folder with poses and contacts here.")
    ] = None,
    figures: Annotated[
        Path | None, typer.Option(help="Write one picture a shot into this folder.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, max=256, help="Processes; default: one a processor.")
    ] = None,
    json: Json = False,
) -> None:
    """Measure the collisions in frames."""
    from rigctl.commands.analyse import Request
    from rigctl.commands.analyse import analyse as measure

    request = Request(
        paths=paths,
        setup=setup,
        sigma_px=sigma_px,
        samples_per_pixel=samples,
        matching=matching.value,
        three_and_three=three,
        out=out,
        figures=figures,
        workers=workers,
        method=method.value,
    )
    measure(request, as_json=json)


model = typer.Typer(help="Compare a campaign with the model; find the effect it lacks.")
app.add_typer(model, name="model", no_args_is_help=True)

Campaign = Annotated[Path, typer.Argument(help="Campaign folder.")]
With = Annotated[
    list[str] | None,
    typer.Option("--with", help="Add this effect of the catalogue; may be given several times."),
]
OwnEffects = Annotated[
    Path | None,
    typer.Option("--effects", help="Folder of effects of your own, beside the catalogue."),
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
    json: Json = False,
) -> None:
    """Say where the model and the campaign agree, and where they do not."""
    from rigctl.commands.model.agreement import agreement

    found = agreement(campaign, effects or [], as_json=json, folder=folder)
    if out is not None:
        from rigctl.commands.model.pictures import draw_agreement

        _say_written(draw_agreement(out, found))


@model.command("fit")
def model_fit(
    campaign: Campaign, *, effects: With = None, folder: OwnEffects = None, json: Json = False
) -> None:
    """Fit e, mu, beta0 and the effects added to all poses of a campaign."""
    from rigctl.commands.model.fit import fit

    fit(campaign, effects or [], as_json=json, folder=folder)


@model.command("rank")
def model_rank(
    campaign: Campaign,
    *,
    effects: With = None,
    folder: OwnEffects = None,
    out: Pictures = None,
    json: Json = False,
) -> None:
    """Rank the effects of the catalogue by what they promise."""
    from rigctl.commands.model.rank import ranking

    found = ranking(campaign, effects or [], as_json=json, folder=folder)
    if out is not None:
        from rigctl.commands.model.pictures import draw_ranking

        _say_written(draw_ranking(out, *found))


@model.command("launch")
def model_launch(campaign: Campaign, *, effects: With = None, json: Json = False) -> None:
    """Fit the launches from the settings, and rank the effects of the launch."""
    from rigctl.commands.model.launch import launch

    launch(campaign, effects or [], as_json=json)


@model.command("explain")
def model_explain(
    campaign: Campaign, *, folder: OwnEffects = None, out: Pictures = None, json: Json = False
) -> None:
    """Find what is missing, add it, and say how much of the error it removes."""
    from rigctl.commands.model.explain import explaining

    found = explaining(campaign, as_json=json, folder=folder)
    if out is not None:
        from rigctl.commands.model.pictures import draw_explanation

        _say_written(draw_explanation(out, *found))


def _say_written(paths: list[Path]) -> None:
    for path in paths:
        typer.echo(f"{path}", err=True)


effect = typer.Typer(help="The effects that a campaign may lack, and effects of your own.")
app.add_typer(effect, name="effect", no_args_is_help=True)


class EffectStage(StrEnum):
    """Where on the way from contact to image an effect acts."""

    CONTACT = "contact"
    FLIGHT = "flight"
    CAMERA = "camera"
    CLOCK = "clock"


@effect.command("new")
def effect_new(
    name: Annotated[str, typer.Argument(help="Its name: lower case, words joined by hyphens.")],
    *,
    stage: Annotated[EffectStage, typer.Option(help="Where it acts.")] = EffectStage.CONTACT,
    folder: Annotated[Path, typer.Option(help="Folder the file is written to.")] = Path("effects"),
) -> None:
    """Write a file to fill in for an effect of your own."""
    from rigctl.commands.effect import new

    path = new(name, stage=stage.value, folder=folder)
    typer.echo(f"{path}: fill it in, then rigctl model rank CAMPAIGN --effects {folder}")


@effect.command("list")
def effect_list(*, folder: OwnEffects = None, json: Json = False) -> None:
    """List all effects with their stages and parameters."""
    from rigctl.commands.effect import listing

    listing(folder, as_json=json)


@effect.command("show")
def effect_show(
    name: Annotated[str, typer.Argument(help="Name of the effect.")],
    *,
    folder: OwnEffects = None,
    json: Json = False,
) -> None:
    """Say what an effect is, what gives it away, and what it is confused with."""
    from rigctl.commands.effect import show

    show(name, folder, as_json=json)


challenge = typer.Typer(help="A campaign that hides an effect, your answer, and the truth.")
app.add_typer(challenge, name="challenge", no_args_is_help=True)

Folder = Annotated[Path, typer.Argument(help="Folder of the challenge.")]


class Strength(StrEnum):
    """How strong what is hidden is."""

    FULL = "full"
    QUARTER = "quarter"


@challenge.command("new")
def challenge_new(
    folder: Folder,
    *,
    seed: Annotated[
        int | None, typer.Option(min=0, help="Gives the same folder again; without it by chance.")
    ] = None,
    strength: Annotated[
        Strength, typer.Option(help="Of what is hidden: as a rig would have it, or a quarter.")
    ] = Strength.FULL,
    shots: Annotated[int, typer.Option(min=3, max=10_000, help="Number of shots.")] = 120,
) -> None:
    """Write a campaign of poses that hides an effect, or two, or none."""
    from rigctl.commands.challenge import new

    new(folder, seed=seed, strength=strength.value, shots=shots)
    typer.echo(f"{folder}: {shots} shots; answer with rigctl challenge commit {folder}")


@challenge.command("commit")
def challenge_commit(
    folder: Folder,
    *,
    answer: Annotated[
        str, typer.Option(help="Names of effects, separated by commas; or none, or unexplained.")
    ],
) -> None:
    """Set down your answer, once and for all."""
    from analysis.effects.catalogue import CATALOGUE
    from rigctl.commands.challenge import commit

    names = commit(folder, answer, known=[effect.name for effect in CATALOGUE])
    typer.echo(f"{folder}: {', '.join(names)}; see the truth with rigctl challenge reveal {folder}")


@challenge.command("reveal")
def challenge_reveal(folder: Folder, *, json: Json = False) -> None:
    """Say what was hidden, and how your answer stands to it."""
    from rigctl.commands.challenge import reveal, summary

    typer.echo(summary(*reveal(folder), as_json=json))


def run(arguments: list[str]) -> int:
    """Run one command and return its exit code; what failed stands on standard error.

    0 is success, 2 bad input, 3 a rig that refuses or cannot, 4 "not found", 130 an interruption
    by Ctrl-C, 1 anything else.
    """
    try:
        code = app(arguments or ["--help"], prog_name="rigctl", standalone_mode=False)
    except RigError as error:
        typer.echo(f"rigctl: {error.sentence()}", err=True)
        return next((code for kind, code in _EXIT_CODES if isinstance(error, kind)), 1)
    except TyperException as error:
        typer.echo(f"rigctl: {error.format_message()}", err=True)
        return BAD_INPUT
    return code if isinstance(code, int) else 0


def main() -> None:
    """Entry point of the `rigctl` script."""
    sys.exit(run(sys.argv[1:]))
