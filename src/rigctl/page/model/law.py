"""A law that no catalogue holds: asked for beside `unexplained`, and one click from a sweep."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from analysis.model.proposals.words import proposal_sentences
from rigctl.jobs import Job
from rigctl.page.model.state import ModelState, Question
from rigctl.page.parts.widgets import button
from rigctl.page.sweeps.form import form_address
from rigctl.sweeps.form import Sweep

Json = dict[str, Any]


class ProposedLaw:
    """The button that asks for a law, and what came of it; `refresh` draws the place anew."""

    def __init__(self, state: ModelState, refresh: Callable[[], object]) -> None:
        self._state, self._refresh = state, refresh
        self._asked = Question(self._ask, state.source.daemon.jobs.job)

    @property
    def running(self) -> str:
        """The job that looks for a law; empty while none does."""
        return self._asked.running or ""

    def follow(self) -> bool:
        """Fetch the answer if it came; say whether anything ended."""
        return self._asked.follow()

    def show(self) -> None:
        """Place the button, or the answer."""
        if self._asked.running is None and self._asked.answer is None:
            placed = button("Propose a law", self._start, testid="propose")
            placed.tooltip("tries what depends on what, with an error rate that holds")
        if self._asked.failure:
            ui.label(self._asked.failure).classes("note")
        if self._asked.answer is not None:
            with ui.element("div").props("data-testid=proposed"):
                for said in proposal_sentences(self._asked.answer):
                    ui.label(said)
                self._into_sweep(self._asked.answer)

    def _into_sweep(self, answer: Json) -> None:
        """Offer the next shots as a sweep, unless another laboratory fired this campaign."""
        shots = [shot for one in answer["proposals"] for shot in one["next_shots"]]
        source = self._state.source
        if not shots:
            return
        if source.folder is not None:
            ui.label(
                "Its next shots are for the rig that fired this campaign: rigctl model propose "
                "--write writes them as a sweep file."
            ).classes("note")
            return
        note = f"confirms a law proposed after {source.title}"
        sweep = Sweep.model_validate({"note": note, "shots": shots, "campaign": source.title})
        button(
            "Make a sweep of its next shots",
            lambda: ui.navigate.to(form_address(sweep)),
            testid="law-into-sweep",
        )

    def _start(self) -> None:
        self._asked.start()
        self._refresh()

    def _ask(self) -> Job:
        limits = self._state.source.daemon.configuration.limits
        return self._state.source.ask(
            "propose",
            self._state.effects,
            limits=[list(limits.pressure_kpa), list(limits.offset_mm)],
        )
