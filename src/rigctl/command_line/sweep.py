"""Commands of sweeps: run one, watch it, pause it, let it go on, give it up."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from typer.core import TyperGroup

from rigctl.access.strength import Chosen, chosen_key
from rigctl.command_line.options import Config, Json, Key, KeyFile


class _Runs(TyperGroup):
    """Takes whatever names none of its commands as arguments of `run`."""

    def parse_args(  # type: ignore[override]  # the context that the base declares is private
        self, ctx: typer.Context, args: list[str]
    ) -> list[str]:
        if args and args[0] not in self.commands and args[0] != "--help":
            args = ["run", *args]
        return super().parse_args(ctx, args)


sweep = typer.Typer(
    cls=_Runs,
    help="Fire many shots one after another: rigctl sweep FILE, or with ranges as options.",
)

Values = typer.Option(metavar="A:B:N", help="N values from A to B, or a list A,B,C; kPa.")
Name = Annotated[str | None, typer.Argument(metavar="[SWEEP]", help="Without it the latest.")]


@sweep.command("run")
def run(
    file: Annotated[Path | None, typer.Argument(help="Sweep file (TOML).")] = None,
    *,
    pressure_kpa: Annotated[str | None, Values] = None,
    pressure_b_kpa: Annotated[
        str | None, typer.Option(metavar="A:B:N", help="Likewise of pusher b; as a without it.")
    ] = None,
    offset_mm: Annotated[
        str | None, typer.Option(metavar="A:B:N", help="Offset of tube b below a, likewise; mm.")
    ] = None,
    repeat: Annotated[int, typer.Option(min=1, max=1000, help="How often all is fired.")] = 1,
    shuffle: Annotated[
        bool, typer.Option(help="Fire in a drawn order, so that a drift is no effect of a setting.")
    ] = True,
    seed: Annotated[int, typer.Option(min=0, help="Draws the order.")] = 0,
    settle_s: Annotated[
        float, typer.Option(min=0.0, help="Wait between settings reached and fire, s.")
    ] = 0.0,
    pause_s: Annotated[float, typer.Option(min=0.0, help="Rest after each shot, s.")] = 0.0,
    until: Annotated[
        str | None,
        typer.Option(metavar="NAME=SIGMA", help="End once e or beta is known so well: e=0.001."),
    ] = None,
    adaptive: Annotated[
        bool, typer.Option("--adaptive", help="Fire where most is learned of what --until names.")
    ] = False,
    campaign: Annotated[str | None, typer.Option(help="Campaign the shots belong to.")] = None,
    detach: Annotated[bool, typer.Option("--detach", help="Do not watch it to its end.")] = False,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Run a sweep through the daemon and watch it to its end."""
    from rigctl.commands.rig import sweep as commands
    from rigctl.commands.rig.sweep_options import Options, form_of

    options = Options(
        file=file,
        pressure_kpa=pressure_kpa,
        pressure_b_kpa=pressure_b_kpa,
        offset_mm=offset_mm,
        repeat=repeat,
        shuffle=shuffle,
        seed=seed,
        settle_s=settle_s,
        pause_s=pause_s,
        until=until,
        adaptive=adaptive,
        campaign=campaign,
    )
    form = form_of(options)
    with commands.service(config, chosen_key(key, key_file)) as daemon:
        commands.run(daemon, form, watch=not detach, as_json=json)


@sweep.command()
def status(
    name: Name = None,
    *,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Show how far a sweep is, how long it will take, and what became of its steps."""
    from rigctl.commands.rig import sweep as commands

    with commands.service(config, chosen_key(key, key_file)) as daemon:
        commands.show(daemon, name, as_json=json)


@sweep.command()
def pause(
    name: Name = None,
    *,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Fire nothing more until it is resumed; a shot under way still ends."""
    _order("pause", name, config, chosen_key(key, key_file), as_json=json)


@sweep.command()
def resume(
    name: Name = None,
    *,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Go on at the next step that has not fired."""
    _order("resume", name, config, chosen_key(key, key_file), as_json=json)


@sweep.command()
def abort(
    name: Name = None,
    *,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Give it up; a shot under way still ends, and nothing stays armed."""
    _order("abort", name, config, chosen_key(key, key_file), as_json=json)


def _order(
    wish: str, name: str | None, config: Path | None, key: Chosen | None, *, as_json: bool
) -> None:
    from rigctl.commands.rig import sweep as commands

    with commands.service(config, key) as daemon:
        commands.order(daemon, wish, name, as_json=as_json)
