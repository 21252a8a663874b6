"""Next shots: the settings that tell two effects apart, one click from a sweep."""

from __future__ import annotations

from typing import Any

from nicegui import ui

from rigctl.jobs import Job
from rigctl.model.next_words import sentence, sweep_of
from rigctl.page.desk import Desk
from rigctl.page.model.state import ModelState, Question
from rigctl.page.parts.tables import Line, facts
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button
from rigctl.page.sweeps.form import form_address, shot_headings

Json = dict[str, Any]
NONE = "none"
PROBABILITY = 0.9


class NextShots:
    """Two effects to choose, and the shots that tell them apart."""

    def __init__(self, desk: Desk, state: ModelState) -> None:
        self._desk, self._state = desk, state
        self._pair: list[str] = []
        self._asked = Question(self._ask, desk.daemon.jobs.job)
        with ui.element("div").classes("panel").props("data-testid=next-shots"):
            self.show()
            Waiting(desk, "Choosing shots", lambda: self._asked.running or "", "choosing")

    def follow(self) -> None:
        """Show the answer once it has come."""
        if self._asked.follow():
            self.show.refresh()

    @ui.refreshable_method
    def show(self) -> None:
        """Place the question, and the answer if there is one."""
        ui.label("Next shots").classes("title").tooltip(
            "The settings within the rig's limits at which two effects foretell most differently."
        )
        present = self._state.present
        if present is None:
            ui.label("Known once the model is fitted.").classes("note")
            return
        names = [
            c["effect"]
            for c in present["candidates"]
            if c["seen"] and c["effect"] not in present["with"]
        ]
        self._pair = _likely(present, names)
        with ui.element("div").classes("beside"):
            ui.label("Tell")
            self._select([*names, NONE], 0)
            ui.label("from")
            self._select([*names, NONE], 1)
            ask = button("Choose shots", self._start, testid="choose-shots")
            ask.set_enabled(self._asked.running is None)
            ui.label(
                "The settings within the rig's limits at which the two foretell most differently."
            ).classes("aside")
        self._answer()

    def _select(self, names: list[str], place: int) -> None:
        chosen = ui.select(names, value=self._pair[place], with_input=True)
        chosen.props(f"outlined dense options-dense data-testid=tell-{place}")
        chosen.props(f'aria-label="{("effect", "to be told from")[place]}"')
        chosen.style("min-width: min(230px, 100%)")
        chosen.on_value_change(lambda event: self._pair.__setitem__(place, event.value))

    def _answer(self) -> None:
        if self._asked.failure:
            ui.label(self._asked.failure).classes("verdict bad")
        answer = self._asked.answer
        if answer is None:
            return
        ui.label(sentence(answer))
        if answer["next_shots"]:
            lines = [
                Line(
                    [
                        f"{shot['pressure_a_kpa']:g}",
                        f"{shot['pressure_b_kpa']:g}",
                        f"{shot['offset_mm']:g}",
                        str(shot["repeat"]),
                    ]
                )
                for shot in answer["next_shots"]
            ]
            facts(shot_headings(), lines, "chosen")
            self._into_sweep(answer)

    def _into_sweep(self, answer: Json) -> None:
        """Offer the shots as a sweep, unless another laboratory fired this campaign."""
        source = self._state.source
        if source.folder is not None:
            ui.label(
                "These shots are for the rig that fired this campaign: rigctl model next --out "
                "writes them as a sweep file."
            ).classes("note")
            return
        sweep = sweep_of(answer).model_copy(update={"campaign": source.title})
        with ui.element("div").classes("beside"):
            button(
                "Make a sweep of them",
                lambda: ui.navigate.to(form_address(sweep)),
                look="fill",
                testid="into-sweep",
            )
            ui.label("Its form opens; nothing is fired before you press Start there.").classes(
                "aside"
            )

    def _start(self) -> None:
        self._asked.start()
        self.show.refresh()

    def _ask(self) -> Job:
        limits = self._desk.daemon.configuration.limits
        return self._state.source.ask(
            "next",
            self._state.effects,
            between=list(self._pair),
            sharpen=None,
            to=None,
            probability=PROBABILITY,
            limits=[list(limits.pressure_kpa), list(limits.offset_mm)],
        )


def _likely(found: Json, names: list[str]) -> list[str]:
    """Return the two that are worth telling apart: the best candidate and what is like it."""
    best = names[0] if names else NONE
    like: list[str] = next((c["like"] for c in found["candidates"] if c["effect"] == best), [])
    other = next((name for name in like if name in names), None)
    return [best, other or (names[1] if len(names) > 1 else NONE)]
