"""`rigctl demo`: a simulated rig hides an effect; fire, measure, compare, find it, add it."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Protocol, cast

import typer

from analysis.effects.catalogue import CATALOGUE
from analysis.figures.error_path import error_path_figure
from analysis.figures.sheet import write
from analysis.figures.shot import draw_shot
from analysis.model.verdict.documents import verdict_report
from analysis.model.verdict.selection import Verdict, explain
from analysis.shot import AnalysisOptions, MeasuredShot, analyse_shot
from rigctl.challenge import commit
from rigctl.cli.output import progress
from rigctl.cli.rig.demo_report import Story, print_story
from rigctl.config import Configuration, Simulation, load
from rigctl.daemon import Daemon, open_daemon
from rigctl.documents import Json
from rigctl.firing import measured
from rigctl.local import LocalRig
from rigctl.measuring.stored_shot import manifest_setup
from rigctl.model.campaigns import campaign_poses
from rigctl.settings import ShotSettings

CAMPAIGN = "demo"
FACTORY = "simulators.laboratory:open_laboratory"
SWEEP = (
    *((34.0, 4.0), (70.0, 12.0), (46.0, 8.0), (58.0, 2.0), (40.0, 14.0)),
    *((52.0, 10.0), (74.0, 9.0), (44.0, 12.0), (67.0, 3.0), (55.0, 15.0)),
)
"""Pressure (kPa) and offset (mm) of each shot: slow and fast, nearly head on to oblique."""
FRAMES_AFTER_MARK = 90
"""The slowest of the sweep meet 60 ms after the fire."""
LONGEST_COLLECTION_S, LONGEST_ANALYSIS_S = 60.0, 120.0
"""On a machine that is busy with other things."""
WORTH = 0.95
"""An effect belongs to the answer if it leaves less than this of the error on shots left out: what
asks for smaller corrections may be the measurement itself."""


class TruthKeeper(Protocol):
    """The part of a simulated laboratory that knows what really happened."""

    @property
    def truth_folder(self) -> Path:
        """Folder of truth.jsonl and of the sealed label; the daemon never reads it."""


def demo(
    *,
    out: Annotated[Path, typer.Option(help="Folder for the frames, results and pictures.")] = Path(
        "out"
    ),
    seed: Annotated[int, typer.Option(min=0, help="Another number, another effect hidden.")] = 8,
) -> None:
    """Fire the sweep, go the whole way to a verdict, commit it, and only then see the truth.

    Everything it writes lies below `out`, whose `demo` folder is emptied first. The seed draws the
    hidden effect, the scatter of the launches and the noise of the camera.

    Raises
    ------
    RigError
        The rig refused, a device failed, or no shot could be measured.
    """
    folder = out / "demo"
    shutil.rmtree(folder, ignore_errors=True)
    with open_daemon(_configuration(folder, seed)) as daemon, progress() as report:
        records = _fire(daemon, report)
        report("comparing with the model")
        _, data = campaign_poses(daemon.store, CAMPAIGN)
        verdict = explain(data, CATALOGUE, report)
        # The factory named in the configuration decides what the laboratory is.
        truth = cast("TruthKeeper", daemon.laboratory).truth_folder
        report("drawing")
        figure = error_path_figure(f"{CAMPAIGN}: the error falls", verdict.path)
        pictures = [*_draw(daemon, records, out / "shot.png"), *write(figure, out, "error-path")]
    found = verdict_report(CAMPAIGN, data, verdict)
    answer = commit(truth, ",".join(answer_of(verdict)), known=[each.name for each in CATALOGUE])
    print_story(Story(records, found, answer, truth), pictures, folder)


def _configuration(folder: Path, seed: int) -> Configuration:
    usual = load(None)
    hiding = {"factory": FACTORY, "seed": seed, "hides": "drawn"}
    return usual.model_copy(
        update={
            "simulation": Simulation.model_validate(hiding),
            "store": usual.store.model_copy(update={"folder": str(folder)}),
            "camera": usual.camera.model_copy(
                update={
                    "frames_after_mark": FRAMES_AFTER_MARK,
                    "collect_timeout_s": LONGEST_COLLECTION_S,
                }
            ),
        }
    )


def _fire(daemon: Daemon, report: Callable[[str], None]) -> list[Json]:
    """Fire the sweep while earlier shots are measured; return the shots with their results."""
    rig, names = LocalRig(daemon, "demo"), []
    for number, (pressure, offset) in enumerate(SWEEP, start=1):
        report(f"shot {number} of {len(SWEEP)}")
        token = rig.arm(
            ShotSettings(pressure_a_kpa=pressure, pressure_b_kpa=pressure, offset_mm=offset)
        )
        # Each shot of the demo has one key, so that none can fire twice.
        names.append(rig.fire(token, f"{CAMPAIGN}-{number}", CAMPAIGN))
        daemon.rig.wait(names[-1])
    report("waiting for the measurements")
    return [measured(rig, name, LONGEST_ANALYSIS_S) for name in names]


def _draw(daemon: Daemon, records: list[Json], path: Path) -> list[Path]:
    """Draw the first shot that was measured; return the picture."""
    record = next(each for each in records if each["state"] == "analysed")
    name = str(record["shot"])
    frames = daemon.store.folders.frames(name)
    setup = manifest_setup(daemon.store.folders.manifest(name))
    options = AnalysisOptions(method=daemon.configuration.analysis.method)
    shot = analyse_shot(frames.pixels, frames.times_s - frames.times_s[0], setup, options)
    if not isinstance(shot, MeasuredShot):
        return []
    settings = record["settings"]
    title = (
        f"shot {name}: {settings['pressure_a_kpa']:g} kPa, offset {settings['offset_mm']:g} mm, "
        "simulated"
    )
    draw_shot(path, title, frames.pixels, shot)
    return [path]


def answer_of(verdict: Verdict) -> list[str]:
    """Return the effects whose adding is worth it, or what the verdict says instead of names.

    Where the verdict leaves nothing unexplained, the first that it names is the answer at least.
    """
    named = [
        effect
        for before, after in pairwise(verdict.path)
        if after.error.value < WORTH * before.error.value
        for effect in after.effects
        if effect not in before.effects and effect in verdict.effects
    ]
    if named or verdict.verdict in {"none", "unexplained"}:
        return named or [verdict.verdict]
    return list(verdict.effects[:1])
