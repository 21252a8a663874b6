"""What came of films: a line for each, all bounces, figures, files to save, and the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from nicegui import ui

from analysis.errors import counted
from analysis.quantity import Quantity
from rigctl.documents import Json
from rigctl.page.desk import Desk
from rigctl.page.model.source import Source
from rigctl.page.own.brought import CAMPAIGN, FIGURE, MEASURED, RESULT, Brought
from rigctl.page.own.downloads import ADDRESS
from rigctl.page.parts.tables import Cell, Line, facts
from rigctl.page.parts.widgets import button

FEWEST_IMPACTS = 5
"""So many are compared with the model; fewer are not compared."""


@dataclass(frozen=True, slots=True)
class MeasuredFilms:
    """Results and failures by the place of their film; `current` is the one that is measured."""

    desk: Desk
    brought: Brought
    names: Sequence[str]
    results: Mapping[int, Json]
    failures: Mapping[int, str]
    current: int | None

    def place(self) -> None:
        """Place all that is known."""
        if not self.results and not self.failures and self.current is None:
            ui.label("Bounces, their speeds and e come here, with their errors.").classes("empty")
            return
        if len(self.names) > 1:
            facts(["film", "what became of it"], [self._line(k) for k in range(len(self.names))])
        for number, failure in self.failures.items():
            ui.label(f"{self.names[number]}: {failure}").classes("verdict bad").props(
                "data-testid=own-failed"
            )
        if self.results:
            first = "bounce" if len(self.names) == 1 else "film / bounce"
            headings = [first, "at", "before, m/s", "after, m/s", "e"]
            facts(headings, self._bounces(), "own-bounces")
            for number, answer in self.results.items():
                for note in answer["notes"]:
                    ui.label(f"{self.names[number]}: {note}").classes("note")
            self._files()
            if self.current is None:
                impacts = sum(len(answer["impacts"]) for answer in self.results.values())
                onwards(self.desk, self.brought.folder / MEASURED / CAMPAIGN, impacts, "bounces")

    def _line(self, number: int) -> Line:
        if number in self.results:
            said = f"✓ {counted(len(self.results[number]['impacts']), 'bounce')}"
        elif number in self.failures:
            said = "▲ not measured"
        else:
            said = "being measured …" if number == self.current else "waits"
        return Line([Cell(self.names[number], look="wrap"), Cell(said, look="left")])

    def _bounces(self) -> list[Line]:
        lines = []
        for film, answer in sorted(self.results.items()):
            for number, each in enumerate(answer["impacts"], start=1):
                when = Quantity(each["contact_time_s"], each["contact_time_sigma_s"], "s").concise()
                numbers = [
                    Quantity.from_json(each[key]).concise().removeprefix("-")
                    for key in ("v_n", "v_n_after", "e")
                ]
                name = str(number) if len(self.names) == 1 else f"{film + 1} / {number}"
                lines.append(Line([name, f"{when} s", *numbers]))
        return lines

    def _files(self) -> None:
        address = f"{ADDRESS}/{self.brought.token}"
        for film in sorted(self.results):
            name = f"{FIGURE}-{film + 1}.png"
            files = [(f"{RESULT}-{film + 1}.json", "all numbers as JSON")]
            # Of bounces that were heard there is no picture.
            if (self.brought.folder / MEASURED / name).exists():
                files.insert(0, (name, "the picture"))
                ui.html(
                    f'<img src="{address}/{name}" alt="The ball\'s places, flights and bounces, '
                    'and what is left beside the flights.">',
                    sanitize=False,
                ).classes("own-figure").props(
                    "tabindex=0 role=region aria-label='Picture of the measured flights'"
                )
            with ui.element("div").classes("beside"):
                for file, words in files:
                    ui.link(f"Save {words}", f"{address}/{file}").props(f'download="{file}"')
        save_campaign(self.brought)


def save_campaign(brought: Brought) -> None:
    """Place the link that saves the campaign's folder."""
    name = f"{CAMPAIGN}.zip"
    link = ui.link("Save the campaign's folder as ZIP", f"{ADDRESS}/{brought.token}/{name}")
    link.props(f'download="{name}"')


def onwards(desk: Desk, campaign: Path, impacts: int, words: str) -> None:
    """Offer the model, where there are impacts enough to say anything."""
    if impacts < FEWEST_IMPACTS:
        ui.label(
            f"{impacts} {words} are too few for the model; {FEWEST_IMPACTS} and more at several "
            "speeds tell whether e depends on speed."
        ).classes("note")
        return
    button(
        "Compare with the model",
        lambda: ui.navigate.to(Source.of_folder(desk.daemon, str(campaign)).address),
        look="fill",
        testid="own-compare",
    )
