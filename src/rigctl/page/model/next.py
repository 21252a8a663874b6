"""Next shots: the settings that tell two effects apart, one click from a sweep."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from nicegui import ui

from analysis.model.verdict.standing import Standing, Word
from rigctl.documents import Json
from rigctl.jobs import Job
from rigctl.model.next_words import sentence, sweep_of
from rigctl.page.desk import Desk
from rigctl.page.model.compare import parsed
from rigctl.page.model.state import ModelState, Question
from rigctl.page.model.story.cards import in_plain, named, titled
from rigctl.page.parts.tables import Line, facts
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button
from rigctl.page.sweeps.broad import broad_sweep
from rigctl.page.sweeps.form import form_address, shot_headings

SPEED = "ln v_n"
NO_SHOTS = frozenset({Word.FLOOR})
FACTOR = 1.5
"""So far beyond the least and the largest speed a further one is worth its effort."""
WIDE = 1.3
"""A gap between neighbouring speeds is named from this ratio on."""


def is_table(found: Json) -> bool:
    """Say whether a fit's campaign has no poses: nobody knows what another shot would show."""
    return not found["paths"]


def none_needed(standing: Standing) -> str:
    """Say that no shots are needed: as what is missing is named, or as nothing is."""
    if standing.word is Word.FLOOR:
        return "None are needed: these shots show nothing that is missing."
    return "None are needed to name what is missing."


def next_measurements(found: Json, standing: Standing) -> str:
    """Say which measurements would tell most, by the speeds that the table has."""
    speeds = speeds_of(found)
    if standing.word in NO_SHOTS:
        return none_needed(standing)
    if len(speeds) < 2:
        return "Measure more impacts, at several approach speeds: these have one alone."
    why = "laws that agree in between part there"
    if standing.tell is not None:
        one, other = (named(name) for name in standing.tell)
        why = f"{one} and {other}, which agree in between, part there"
    low, high = speeds[0] / FACTOR, speeds[-1] * FACTOR
    said = f"Measure next below {low:.2g} m/s and above {high:.2g} m/s: {why}."
    ratio, left, right = max((b / a, a, b) for a, b in pairwise(speeds))
    if ratio > WIDE:
        said += f" The widest gap of the table lies between {left:.2g} and {right:.2g} m/s."
    return said


def speeds_of(found: Json) -> Sequence[float]:
    """Return the approach speeds of a table, ascending, m/s; none where no finding has them."""
    cell = next((one for one in found["findings"] if one["covariate"] == SPEED), None)
    return [] if cell is None else sorted({math.exp(x) for x in parsed(cell["points"])["x"]})


NONE = "none"
NO_EFFECT = "No further effect"
PROBABILITY = 0.9
COMMAND = "rigctl model next --out"
MORE_SHOTS = frozenset({Word.FEW, Word.UNSURE, Word.UNEXPLAINED})


class NextShots:
    """The shots that the verdict asks for, and any two effects to distinguish besides.

    Where the verdict leaves two effects open, their shots are chosen without being asked: one
    click makes a sweep of them, one more starts it.
    """

    def __init__(self, desk: Desk, state: ModelState) -> None:
        self._desk, self._state = desk, state
        self._pair: list[str] = []
        self._chosen_for: object = None
        self._choose: ui.button | None = None
        self._asked = Question(self._ask, desk.daemon.jobs.job, state.source.without_its_folder)
        with ui.element("div").classes("panel").props("data-testid=next-shots"):
            self.show()
            Waiting(desk, "Choosing shots", lambda: self._asked.running or "", "choosing")

    def follow(self) -> None:
        """Show the answer once it has come."""
        if self._asked.follow():
            self._draw()

    @ui.refreshable_method
    def show(self) -> None:
        """Place what the verdict asks for, the answer if there is one, and a question beside it."""
        ui.label("Next shots").classes("title").tooltip(
            "Settings within the rig's limits at which the predictions of two effects differ most."
        )
        present, standing = self._state.present, self._state.standing
        if present is None or standing is None:
            ui.label("Known once the model is fitted.").classes("note")
            return
        if is_table(present):
            ui.label(next_measurements(present, standing)).props("data-testid=next-text")
            return
        ui.label(in_plain(asked_for(standing))).props("data-testid=next-text")
        if standing.word in MORE_SHOTS:
            self._more()
        names = [
            c["effect"]
            for c in present["candidates"]
            if c["seen"] and c["effect"] not in present["with"]
        ]
        asked = standing.tell, self._state.effects
        if self._chosen_for != asked:
            self._chosen_for = asked
            self._pair = list(standing.tell or _likely(present, names))
            self._asked.forget()
            if standing.tell is not None:
                self._asked.start()
        self._answer()
        self._of_ones_own(list(dict.fromkeys([*names, *self._pair, NONE])))

    def _more(self) -> None:
        """Offer shots all over the plane, unless another laboratory fired this campaign."""
        source = self._state.source
        sweep = broad_sweep(source.title, self._desk.daemon.configuration.limits)
        if source.elsewhere(COMMAND) is None and sweep is not None:
            button(
                f"Make a sweep of {sweep.count()} shots",
                lambda: ui.navigate.to(form_address(sweep)),
                look="fill",
                testid="more-shots",
            )

    def _of_ones_own(self, names: list[str]) -> None:
        with ui.element("div").classes("beside"):
            ui.label("Others, if you want to: tell")
            self._select(names, 0)
            ui.label("from")
            self._select(names, 1)
            self._choose = button("Choose shots", self._start, testid="choose-shots")
            self._choose.set_enabled(self._asked.running is None)
            ui.label(
                "The settings within the rig's limits at which their predictions differ most."
            ).classes("aside")

    def _select(self, names: list[str], place: int) -> None:
        options = {name: titled(name) for name in names} | {NONE: NO_EFFECT}
        chosen = ui.select(options, value=self._pair[place], with_input=True)
        chosen.props(f"outlined dense options-dense data-testid=tell-{place}")
        chosen.props(f'aria-label="{("effect", "to distinguish it from")[place]}"')
        chosen.style("min-width: min(400px, 100%)")
        chosen.on_value_change(lambda event: self._pair.__setitem__(place, event.value))

    def _draw(self) -> None:
        """Draw the answer anew; the fields beside it stay, with what is being chosen in them."""
        self._answer.refresh()
        if self._choose is not None:
            self._choose.set_enabled(self._asked.running is None)

    @ui.refreshable_method
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
        if (elsewhere := source.elsewhere(COMMAND)) is not None:
            ui.label(f"These shots are {elsewhere}").classes("note").props("data-testid=elsewhere")
            return
        sweep = sweep_of(answer).model_copy(update={"campaign": source.title})
        with ui.element("div").classes("beside"):
            button(
                f"Make a sweep of these {sweep.count()} shots",
                lambda: ui.navigate.to(form_address(sweep)),
                look="fill",
                testid="into-sweep",
            )
            ui.label("Its form opens; nothing is fired before you press Start there.").classes(
                "aside"
            )

    def _start(self) -> None:
        self._asked.start()
        self._draw()

    def _ask(self) -> Job:
        limits = self._desk.daemon.configuration.limits
        # An effect that is to be told from another is not taken for granted.
        given = [name for name in self._state.effects if name not in self._pair]
        return self._state.source.ask(
            "next",
            given,
            between=list(self._pair),
            sharpen=None,
            to=None,
            probability=PROBABILITY,
            limits=[list(limits.pressure_kpa), list(limits.offset_mm)],
        )


def asked_for(standing: Standing) -> str:
    """Say which shots the verdict asks for; none while it leaves nothing open."""
    if standing.tell is not None:
        one, other = standing.tell
        return f"These would tell {one} from {other}:"
    if standing.word in {Word.FEW, Word.UNSURE}:
        return "More shots are needed to say anything, at several pressures and offsets."
    if standing.word is Word.UNEXPLAINED:
        return "More shots, all over pressures and offsets, would show better what it goes with."
    return none_needed(standing)


def _likely(found: Json, names: list[str]) -> list[str]:
    """Return the two that are worth telling apart: the best candidate and what is like it."""
    best = names[0] if names else NONE
    like: list[str] = next((c["like"] for c in found["candidates"] if c["effect"] == best), [])
    other = next((name for name in like if name in names), None)
    return [best, other or (names[1] if len(names) > 1 else NONE)]
