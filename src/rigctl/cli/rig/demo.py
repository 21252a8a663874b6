"""`rigctl demo`: a simulated rig hides an effect; fire, measure, compare, find it, add it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Protocol, cast

import typer
from rich.console import Console
from rich.table import Table

from analysis.effects.catalogue import CATALOGUE
from analysis.figures.error_path import error_path_figure
from analysis.figures.sheet import write
from analysis.figures.shot import draw_shot
from analysis.model.verdict.documents import verdict_report
from analysis.model.verdict.selection import Verdict, explain
from analysis.model.verdict.words import verdict_sentence
from analysis.quantity import Quantity
from analysis.schema.verdict import VerdictReport
from analysis.shot import AnalysisOptions, MeasuredShot, analyse_shot
from rigctl.challenge import commit, reveal, summary
from rigctl.cli.output import progress
from rigctl.config import Configuration, Simulation, load
from rigctl.daemon import Daemon, open_daemon
from rigctl.documents import Json
from rigctl.firing import measured
from rigctl.local import LocalRig
from rigctl.measuring.stored_shot import manifest_setup
from rigctl.model.campaigns import campaign_poses
from rigctl.settings import ShotSettings

WIDTH = 100
"""A narrower terminal wraps the rows; cut digits would be wrong numbers."""
CANDIDATES = 3
MEASURED = (("v_n", "m/s"), ("v_s", "m/s"), ("e", ""), ("beta", ""))


@dataclass(frozen=True, slots=True)
class Story:
    """A demonstration from its first shot to the truth.

    Attributes
    ----------
    records
        Shots as the service shows them, each with its result.
    verdict
        What was concluded, before anything of the truth was seen.
    answer
        Names that were committed to.
    truth
        Folder with truth.jsonl, the sealed label and the answer.
    """

    records: Sequence[Json]
    verdict: VerdictReport
    answer: Sequence[str]
    truth: Path


def print_story(story: Story, pictures: Sequence[Path], folder: Path) -> None:
    """Print the whole story; the truth comes last, and only to a verdict that was committed."""
    console = Console(width=WIDTH, highlight=False)
    console.print(_shots(story))
    console.print()
    console.print(_ranking(story.verdict))
    console.print()
    console.print(_path(story.verdict))
    console.print()
    console.print(verdict_sentence(story.verdict))
    console.print(_committed(story))
    console.print(summary(*reveal(story.truth), as_json=False))
    console.print(f"Pictures: {', '.join(map(str, pictures))}", soft_wrap=True)
    console.print(f"Frames, manifests and results: {folder}", soft_wrap=True)


def _committed(story: Story) -> str:
    """Say what was answered, and what to think of an error that did not reach its floor."""
    said = f"Committed: {', '.join(story.answer)}."
    if not story.verdict.unexplained:
        return said
    return (
        f"{said} Errors of the images that differ from shot to shot, but hardly from frame to "
        "frame, count as structure too: the last tenths above the floor are no reason to add an "
        "effect."
    )


def _shots(story: Story) -> Table:
    """Return measured speeds and coefficients, the simulator's beside the coefficients."""
    table = Table(title="Fire and measure", title_justify="left", box=None)
    headings = ("kPa", "mm", *(f"{name} {unit}".strip() for name, unit in MEASURED))
    for heading in (*headings, "true e", "true beta"):
        table.add_column(heading, justify="right", no_wrap=True)
    truths = _truths(story.truth)
    for number, record in enumerate(story.records, start=1):
        settings, result = record["settings"], record["result"] or {}
        cells = [_cell(result.get(name)) for name, _ in MEASURED]
        cells += _coefficients(truths.get(number, {}))
        table.add_row(f"{settings['pressure_a_kpa']:g}", f"{settings['offset_mm']:g}", *cells)
    table.caption = "in brackets: standard error in units of the last digit"
    return table


def _truths(folder: Path) -> dict[int, Json]:
    lines = (folder / "truth.jsonl").read_text(encoding="utf-8").splitlines()
    return {int(truth["shot"]): truth for truth in map(json.loads, lines)}


def _coefficients(truth: Json) -> list[str]:
    if truth.get("missed", True):
        return ["-", "-"]
    e, beta = -truth["v_n_after"] / truth["v_n"], -truth["v_s_after"] / truth["v_s"]
    return [f"{e:.4f}", f"{beta:.4f}"]


def _cell(quantity: Mapping[str, Any] | None) -> str:
    if quantity is None:
        return "-"
    return Quantity.from_json(quantity).concise()


def _ranking(verdict: VerdictReport) -> Table:
    table = Table(title="Compare and find", title_justify="left", box=None)
    for heading in ("candidate", "score", "chance", "amplitude", "unit"):
        table.add_column(heading, justify="left" if heading in {"candidate", "unit"} else "right")
    for candidate in verdict.candidates[:CANDIDATES]:
        amplitude = Quantity(candidate.amplitude, candidate.sigma, candidate.unit)
        table.add_row(
            candidate.effect,
            f"{candidate.score:.1f}",
            f"{candidate.p_familywise:.1g}",
            amplitude.concise(),
            candidate.unit,
        )
    table.caption = (
        "effects that are not in the fit, the largest expected drop of chi-squared first"
    )
    return table


def _path(verdict: VerdictReport) -> Table:
    table = Table(title="Add, and see the error fall", title_justify="left", box=None)
    for heading in ("with", "chi-squared per dof", "error on shots left out"):
        table.add_column(heading, justify="left" if heading == "with" else "right")
    for stage in verdict.path:
        name = ", ".join(stage.effects) or "the base model"
        table.add_row(name, f"{stage.chi2_per_dof:.3f}", f"{stage.prediction_error:.3f}")
    table.caption = "errors in units of the noise; 1 is the floor"
    if names := taken_out([stage.effects for stage in verdict.path]):
        table.caption += (
            f"\n{', '.join(names)}: added when it lowered the error most by itself, then taken out "
            "again, as the model does as well without it"
        )
    return table


def taken_out(stages: Sequence[Sequence[str]]) -> list[str]:
    """Return the effects that the way to a verdict added and dropped again, in their order."""
    added = dict.fromkeys(effect for effects in stages for effect in effects)
    return [effect for effect in added if effect not in stages[-1]]


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
        armed = rig.arm(
            ShotSettings(pressure_a_kpa=pressure, pressure_b_kpa=pressure, offset_mm=offset)
        )
        # Each shot of the demo has one key, so that none can fire twice.
        names.append(rig.fire(armed.token, f"{CAMPAIGN}-{number}", CAMPAIGN))
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
