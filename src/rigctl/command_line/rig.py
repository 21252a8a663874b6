"""Commands that fire: the daemon, one shot, the demonstration."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from rigctl.access.strength import chosen_key
from rigctl.command_line.options import Config, Json, Key, KeyFile, OwnEffects

rig = typer.Typer()


@rig.command()
def serve(
    *,
    config: Config = None,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="Listen here instead; 0 takes any free port."),
    ] = None,
    key: Annotated[
        str | None,
        typer.Option(help="Key of the service; best in RIGCTL_KEY. Without any a fresh one."),
    ] = None,
    key_file: KeyFile = None,
    effects: OwnEffects = None,
    log: Annotated[
        Literal["text", "json"],
        typer.Option(help="What goes to standard error: warnings, or every step as JSON lines."),
    ] = "text",
) -> None:
    """Run the daemon: REST on 127.0.0.1:8486, the simulated rig by default."""
    import gc

    # What is loaded stays: to look for garbage in it takes a tenth of the start.
    gc.disable()
    try:
        from rigctl.commands.rig.serve import serve as run_daemon
    finally:
        gc.enable()
    run_daemon(config, port, chosen_key(key, key_file), effects, log)


@rig.command()
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
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Fire one shot and print its coefficients."""
    from rigctl.commands.rig.shot import Order, settings_of
    from rigctl.commands.rig.shot import shot as fire

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
        from rigctl.commands.rig.local import opened

        fire(order, opened(config), as_json=json)
    else:
        from rigctl.commands.client import connected

        fire(order, connected(config, chosen_key(key, key_file)), as_json=json)


@rig.command()
def stop(
    *,
    reason: Annotated[
        str, typer.Option(help="Why; it is kept with the stop.")
    ] = "stopped by command",
    config: Config = None,
    json: Json = False,
) -> None:
    """Cut the power of every actuator now, and latch; needs no key."""
    from rigctl.commands.rig.stop import stop as stop_rig

    stop_rig(config, reason, as_json=json)


@rig.command()
def release(
    reason: Annotated[str, typer.Argument(help="What was found and done.")],
    *,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Give power back after a stop, a fault or an unknown outcome, once a person has looked."""
    from rigctl.commands.rig.stop import release as release_rig

    release_rig(config, chosen_key(key, key_file), reason, as_json=json)


@rig.command()
def demo(
    *,
    out: Annotated[Path, typer.Option(help="Folder for the frames, results and pictures.")] = Path(
        "out"
    ),
    seed: Annotated[int, typer.Option(min=0, help="Another number, another effect hidden.")] = 8,
) -> None:
    """Find an effect that a simulated rig hides: fire, measure, compare; no daemon needed."""
    from rigctl.commands.rig.demo import demo as run_demo

    run_demo(out, seed)


@rig.command()
def firmware(
    *,
    out: Annotated[Path, typer.Option(help="Folder for the firmware's source.")] = Path("firmware"),
    port: Annotated[str, typer.Option(help="Where the board is plugged in.")] = "/dev/ttyUSB0",
) -> None:
    """Write out the trigger box's firmware, and say how to build and flash it."""
    from rigctl.commands.rig.firmware import write_firmware

    write_firmware(out, port)


@rig.command()
def precompile() -> None:
    """Compile the analysis for this machine once, a minute or two; no first shot waits for it."""
    from rigctl.commands.analysis.precompile import precompile as run_precompile
    from rigctl.commands.report import progress

    with progress() as say:
        run_precompile(say)
