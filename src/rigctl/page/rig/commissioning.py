"""Commissioning on the page: one step after the other, with what must be seen of it."""

from __future__ import annotations

from nicegui import events, ui

from rigctl.commissioning.answers import NO
from rigctl.commissioning.gate import Standing
from rigctl.page.desk import Desk, actor
from rigctl.page.layout import sheet
from rigctl.page.parts.asking import ask_reason
from rigctl.page.parts.presence import kept_page
from rigctl.page.parts.tables import Cell, Line, facts_html
from rigctl.page.parts.widgets import button

PLACE = "/commissioning"
MARKS = {"holds": "●", "fails": "▲", "waits": "○"}


def commissioning_page(desk: Desk) -> None:
    """Register the page at `/commissioning`."""

    @kept_page(PLACE)
    def page() -> None:
        with sheet(desk, "Commissioning", "/"):
            ui.html("Commissioning", sanitize=False, tag="h2").classes("own-heading")
            ui.label(_why(desk)).classes("note")
            Walk(desk)


class Walk:
    """The step that is asked for, and below it all of them."""

    def __init__(self, desk: Desk) -> None:
        self._desk, self._walk = desk, desk.daemon.commissioning
        self._chosen: str | None = None
        self._said = ""
        self._people = ui.input("Who looks (names, with commas between)")
        self._people.classes("wide").props("outlined dense data-testid=people")
        self.step()
        self.steps()

    @ui.refreshable_method
    def step(self) -> None:
        """Place the step that is asked for, with its buttons."""
        found = self._present()
        with ui.element("div").classes("panel").props("data-testid=step"):
            if found is None:
                ui.label("Every step was seen.").classes("title")
                ui.label("The rig may fire. Choose a step below to see it again.").classes("note")
                return
            step = found.step
            ui.label(f"{step.title} ({step.name})").classes("title")
            ui.label(f"Asked for: {found.missing or 'seen already'}.").classes("note")
            ui.label(f"Do: {step.do}")
            ui.label(f"See: {step.see}")
            said = ui.label(self._said).classes("note").props("data-testid=found role=status")
            said.set_visibility(bool(self._said))
            with ui.element("div").classes("beside"):
                if step.act is not None:
                    words = f"Let the daemon do its part ({step.act})"
                    button(words, lambda: self._act(step.name), look="fill", testid="act")
                button("Seen as stated", lambda: self._seen(step.name), testid="seen")
                button("Not so …", lambda: self._ask_what(step.name), testid="not-seen")

    @ui.refreshable_method
    def steps(self) -> None:
        """Place the list of all steps."""
        standings = self._walk.standings()
        done = sum(not each.missing for each in standings)
        with ui.element("div").classes("panel"):
            ui.label(f"{done} of {len(standings)} steps seen").classes("title")
            heads = [Cell("step"), Cell("part"), Cell("stands")]
            table = facts_html(heads, [_line(each) for each in standings])
            ui.html(table, sanitize=False).classes("wide").props("data-testid=steps")
            names = {each.step.name: each.step.title for each in standings}
            choice = ui.select(names, label="Do a step again", on_change=self._choose)
            choice.classes("wide").props("outlined dense data-testid=again")

    def _present(self) -> Standing | None:
        standings = self._walk.standings()
        chosen = (each for each in standings if each.step.name == self._chosen)
        missing = (each for each in standings if each.missing)
        return next(chosen, None) or next(missing, None)

    def _choose(self, event: events.ValueChangeEventArguments[str]) -> None:
        self._chosen, self._said = event.value, ""
        self.step.refresh()

    async def _act(self, step: str) -> None:
        who = actor()
        found = await self._desk.act(lambda: self._walk.act(step, who), moves=True)
        if found is not None:
            saw = "The daemon saw" if found.holds else "The daemon did NOT see it"
            self._said = f"{saw}: {found.text or 'nothing was to be seen'}"
            self.step.refresh()

    async def _seen(self, step: str) -> None:
        await self._answer(step, "", seen=True)

    def _ask_what(self, step: str) -> None:
        async def say(what: str) -> bool:
            return await self._answer(step, what, seen=False)

        ask_reason("Not as it must be", "What was seen instead? It is kept.", "Keep", say)

    async def _answer(self, step: str, note: str, *, seen: bool) -> bool:
        who, people = actor(), _names(str(self._people.value or ""))
        done = await self._desk.act(
            lambda: self._walk.answer(step, seen=seen, people=people, note=note, actor=who)
        )
        if done is None:
            return False
        self._chosen, self._said = None, ""
        self.step.refresh()
        self.steps.refresh()
        return True


def _names(text: str) -> list[str]:
    return [name.strip() for name in text.split(",") if name.strip()]


def _why(desk: Desk) -> str:
    if desk.daemon.configuration.simulation is not None:
        return "A simulated rig fires without it; here it is a rehearsal."
    return (
        "This rig fires nothing until every step was seen. After a change of configuration, wiring "
        "or firmware it asks for what has changed. Keep the signed record: "
        "`rigctl commission --record FILE`."
    )


def _line(standing: Standing) -> Line:
    step, answer = standing.step, standing.answer
    seen = "" if answer is None else f"seen on {answer.at[:10]} by {', '.join(answer.people)}"
    refused = answer is not None and answer.answer == NO
    look = "holds" if not standing.missing else "fails" if refused else "waits"
    cells = [
        Cell(f"{MARKS[look]} {step.title}", step.see),
        Cell(str(step.part)),
        Cell(standing.missing or seen, look="wrap"),
    ]
    return Line(cells, look)
