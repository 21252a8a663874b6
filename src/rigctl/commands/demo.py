"""`rigctl demo`: a simulated rig fires a small sweep, every shot is measured, truth beside it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np
from rich.console import Console
from rich.table import Table

from analysis.figures.shot import draw_shot
from analysis.quantity import Quantity
from analysis.shot import MeasuredShot, analyse_shot
from rigctl.commands import report
from rigctl.commands.local import LocalRig
from rigctl.commands.shot import Order, fire_and_wait
from rigctl.config import load
from rigctl.daemon import Daemon, open_daemon
from rigctl.settings import ShotSettings
from rigctl.stored_shot import setup_of

SWEEP = ((25.0, 2.0), (40.0, 6.0), (55.0, 9.0), (70.0, 12.0), (60.0, 15.0), (45.0, 18.0))
"""Pressure (kPa) and offset (mm) of each shot: from nearly head on to oblique."""
SHOWN = 3
"""The shot whose picture is drawn."""
LONGEST_ANALYSIS_S = 60.0
COMPARED = ("v_n", "v_s", "v_n_after", "v_s_after")


class TruthKeeper(Protocol):
    """The part of a simulated laboratory that knows what really happened."""

    @property
    def truth_folder(self) -> Path:
        """Folder of truth.jsonl, one line a shot; the daemon never reads it."""


@dataclass(frozen=True, slots=True)
class DemoShot:
    """A fired shot as the service shows it, and its truth."""

    record: Mapping[str, Any]
    truth: Mapping[str, Any]


def demo(out: Path) -> None:
    """Fire the sweep on a simulated rig and print measured beside true; draw one shot.

    Everything it writes lies below `out`, whose `demo` folder is emptied first.

    Raises
    ------
    RigError
        The rig refused or a device failed.
    """
    folder = out / "demo"
    shutil.rmtree(folder, ignore_errors=True)
    configuration = load(None)
    store = configuration.store.model_copy(update={"folder": str(folder)})
    configuration = configuration.model_copy(update={"store": store})
    with open_daemon(configuration) as daemon:
        shots = _fire_sweep(daemon)
        picture = _draw(daemon, shots[SHOWN - 1].record, out / "shot.png")
    console = Console()
    console.print(_table(shots))
    console.print(_verdict(shots), highlight=False)
    if picture is not None:
        console.print(f"One shot with outlines, markers and tracks: {picture}", highlight=False)
    console.print(f"Frames, manifests and results: {folder}", highlight=False)


def _fire_sweep(daemon: Daemon) -> list[DemoShot]:
    rig = LocalRig(daemon, "demo")
    records = []
    with report.progress() as say:
        for number, (pressure, offset) in enumerate(SWEEP, start=1):
            settings = ShotSettings(
                pressure_a_kpa=pressure, pressure_b_kpa=pressure, offset_mm=offset
            )
            order = Order(settings, "demo", LONGEST_ANALYSIS_S)
            tell = partial(_tell, say, f"shot {number} of {len(SWEEP)}")
            records.append(fire_and_wait(rig, order, tell))
    # The factory named in the configuration decides what the laboratory is.
    keeper = cast("TruthKeeper", daemon.laboratory)
    lines = (keeper.truth_folder / "truth.jsonl").read_text().splitlines()
    truths = sorted((json.loads(line) for line in lines), key=lambda truth: int(truth["shot"]))
    return [DemoShot(r, t) for r, t in zip(records, truths, strict=True)]


def _tell(say: Callable[[str], None], shot: str, text: str) -> None:
    say(f"{shot}: {text}")


def _draw(daemon: Daemon, record: Mapping[str, Any], path: Path) -> Path | None:
    """Draw one stored shot; None where it was refused."""
    name = str(record["shot"])
    frames = daemon.store.folders.frames(name)
    setup = setup_of(daemon.store.folders.manifest(name))
    shot = analyse_shot(frames.pixels, frames.times_s - frames.times_s[0], setup)
    if not isinstance(shot, MeasuredShot):
        return None
    settings = record["settings"]
    title = (
        f"shot {name}: {settings['pressure_a_kpa']:g} kPa, offset {settings['offset_mm']:g} mm, "
        "simulated"
    )
    draw_shot(path, title, frames.pixels, shot)
    return path


def _table(shots: list[DemoShot]) -> Table:
    table = Table(title="measured, and the simulator's truth below", title_justify="left")
    table.box, table.padding = None, (0, 1, 0, 0)
    for heading in ("kPa", "mm", "v_n\nm/s", "v_s\nm/s", "v_n'\nm/s", "v_s'\nm/s", "e", "beta"):
        table.add_column(heading, justify="right", no_wrap=True)
    for shot in shots:
        settings, result = shot.record["settings"], shot.record["result"] or {}
        cells = [_cell(result.get(name)) for name in (*COMPARED, "e", "beta")]
        table.add_row(f"{settings['pressure_a_kpa']:g}", f"{settings['offset_mm']:g}", *cells)
        true = shot.truth
        e, beta = -true["v_n_after"] / true["v_n"], -true["v_s_after"] / true["v_s"]
        truths = [*(true[name] for name in COMPARED), e, beta]
        table.add_row("", "", *(f"{value:.4f}" for value in truths), style="dim")
    table.caption = "in brackets: standard error in units of the last digit"
    return table


def _cell(quantity: Mapping[str, Any] | None) -> str:
    if quantity is None:
        return "-"
    return Quantity(quantity["value"], quantity["sigma"], quantity["unit"]).concise()


def _verdict(shots: list[DemoShot]) -> str:
    """Say how many shots were measured and how far e is from the truth, in its own errors."""
    pulls = [
        (s.record["result"]["e"]["value"] + s.truth["v_n_after"] / s.truth["v_n"])
        / s.record["result"]["e"]["sigma"]
        for s in shots
        if (s.record["result"] or {}).get("status") == "measured"
    ]
    if not pulls:
        return f"0 of {len(shots)} shots measured."
    rms = float(np.sqrt(np.mean(np.square(pulls))))
    return (
        f"{len(pulls)} of {len(shots)} shots measured; e lies {rms:.1f} of its stated standard "
        "errors from the truth (RMS)."
    )
