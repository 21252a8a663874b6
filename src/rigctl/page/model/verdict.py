"""The verdict in words: what the fit at hand says, and the way that the daemon goes by itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from analysis.model.fitting.nuisance_words import alarm_sentence
from analysis.model.structure.alarm import FEWEST
from analysis.model.structure.influence import FEW
from analysis.model.verdict.words import doubts, too_few, verdict_sentence
from rigctl.page.desk import Desk
from rigctl.page.model.law import ProposedLaw
from rigctl.page.model.state import ModelState, Question
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button

Json = dict[str, Any]
ALARM = 0.01
STRONG = 0.05


class Verdict:
    """One sentence before any table, and a button that has the whole way gone.

    `worded` puts a sentence into the words of the view.
    """

    def __init__(self, desk: Desk, state: ModelState, worded: Callable[[str], str] = str) -> None:
        self._state, self._worded = state, worded
        jobs = state.source.daemon.jobs
        self._asked = Question(lambda: state.source.ask("explain"), jobs.job)
        self._law = ProposedLaw(state, self.show.refresh)
        self.show()
        Waiting(desk, "Finding what is missing", lambda: self._asked.running or "", "explaining")
        Waiting(desk, "Looking for a law", lambda: self._law.running, "proposing")

    def follow(self) -> None:
        """Show the answer once it has come."""
        if self._asked.follow() | self._law.follow():
            self.show.refresh()

    @ui.refreshable_method
    def show(self) -> None:
        """Place what is known now."""
        present = self._state.present
        lead, rest, good = ("Comparing model and measurement …", "", None)
        if self._state.failure:
            lead = "Model and measurement were not compared."
        if present is not None:
            lead, rest, good = sentence(present)
        look = "" if good is None else (" good" if good else " bad")
        with ui.element("div").classes(f"verdict{look}").props("data-testid=verdict role=status"):
            with ui.element("div").classes("beside"):
                with ui.element("div").classes("said"):
                    ui.label(self._worded(lead)).classes("lead")
                    ui.label(self._worded(rest))
                    for alarm in (present or {}).get("alarms", ()):
                        ui.label(alarm_sentence(alarm)).classes("note").props("data-testid=alarm")
                self._offer()
            self._found()

    def _offer(self) -> None:
        if self._asked.running is None and self._asked.answer is None:
            placed = button("Find it by itself", self._start, testid="explain")
            placed.tooltip("adds effects, drops them again and judges, until nothing is missing")

    def _found(self) -> None:
        if self._asked.failure:
            ui.label(self._asked.failure).classes("note")
        if self._asked.answer is not None:
            said = f"By itself: {verdict_sentence(self._asked.answer)}"
            ui.label(self._worded(said)).props("data-testid=explained")
            for doubt in doubts(self._asked.answer):
                ui.label(doubt).classes("note")
            if self._asked.answer["unexplained"]:
                self._law.show()

    def _start(self) -> None:
        self._asked.start()
        self.show.refresh()


def sentence(found: Json) -> tuple[str, str, bool | None]:
    """Say what a fit leaves open: the point, what goes with it, and whether all is well.

    None where these shots are too few to say.
    """
    error = f"The error on shots left out is {found['prediction_error']:.3f} of the noise"
    if found["shots"] < FEWEST:
        return "Too few shots to tell.", f"{error}; {too_few(found['shots'])}", None
    added = " and ".join(found["with"])
    fails = [
        row
        for stage in found["stages"]
        for row in stage["quantities"]
        if row["p_familywise"] < ALARM
    ]
    left = [cell for cell in found["cells"] if cell["p_familywise"] < ALARM]
    cells = [cell for cell in left if cell["shared"]]
    strong = [
        c
        for c in found["candidates"]
        if c["seen"] and c["p_familywise"] < STRONG and c["effect"] not in found["with"]
    ]
    if not (cells or strong) and (fails or left) and found["shots"] <= FEW:
        lead = f"With {added} nothing more is sure." if added else "Nothing is sure to be missing."
        return lead, f"{error}; {_of_single_shots(fails, left or found['cells'])}", None
    if not (fails or left or strong):
        lead = f"With {added} nothing stands out." if added else "Nothing stands out."
        return lead, f"{error}: these shots show no more than their own noise.", True
    where = f"most in {_worst(fails, cells or left or found['cells'])}"
    lead = f"With {added} something is still missing." if added else "Something is missing."
    if not strong:
        return (
            lead,
            f"{error}; it shows {where}, and no effect that is known explains it.",
            False,
        )
    best = strong[0]
    alike = [name for name in best["like"] if name in {c["effect"] for c in strong}]
    also = f", which these shots do not tell from {' or '.join(alike)}," if alike else ""
    return lead, f"{error}; it shows {where}. {best['effect']}{also} promises most.", False


def _of_single_shots(fails: list[Json], cells: list[Json]) -> str:
    return (
        f"what stands out most, {_worst(fails, cells)}, may be errors of single shots. More than "
        f"{FEW} shots at several pressures and offsets would tell."
    )


def _worst(fails: list[Json], cells: list[Json]) -> str:
    """Name what stands out most: a cell if one does, else the quantity that disagrees."""
    worst = max(cells, key=lambda cell: cell["deviation"])
    if worst["p_familywise"] >= ALARM and fails:
        return str(min(fails, key=lambda row: row["p_familywise"])["quantity"])
    return f"{worst['channel']} against {worst['covariate']}"
