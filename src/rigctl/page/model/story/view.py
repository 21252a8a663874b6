"""The story: compare, where it fails, what is missing, add; each with its result in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from html import escape

from nicegui import ui

from analysis.model.verdict.standing import AT_THE_FLOOR, SURE
from rigctl.documents import Json
from rigctl.page.desk import Desk
from rigctl.page.model.effect_words import described, left_out
from rigctl.page.model.state import Effects, ModelState
from rigctl.page.model.story.bars import Bar, bars
from rigctl.page.model.story.cards import card_of, in_plain
from rigctl.page.model.story.errors import Unseen, falls_to, three_figures
from rigctl.page.model.story.film import ShotFilm, into_view
from rigctl.page.model.story.law import law
from rigctl.page.model.story.lead import drawing, lead_card
from rigctl.page.model.story.plots import before_after, staircase
from rigctl.page.model.story.preview import plainest
from rigctl.page.model.story.where import WhereItFails
from rigctl.page.model.story.words import (
    channel,
    compared,
    failing,
    goes_with,
    missing_words,
)
from rigctl.page.model.where import apart
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button, plot

BARS = 8
LEAST_SPAN = 1.5
"""Errors in units of the noise up to which the scale of the bars goes at least."""
OTHERS = 4


class Story:
    """Four steps, drawn anew with each answer; `take` has the model taken with other effects.

    The first and the last are drawn at once, the others with `rank`: a browser needs a second for
    all of them.
    `last` is where more can be placed after them.
    """

    def __init__(self, desk: Desk, state: ModelState, take: Callable[[Effects], None]) -> None:
        self._desk, self._state, self._take = desk, state, take
        self._shown: Json | None = None
        self._after: Json | None = None
        self._effect, self._waits = "", ""
        self._is_behind = False
        self._film = ShotFilm(desk, state, self._film_chosen)
        self._where = WhereItFails(state, self._to_film, lambda: self._film.shot)
        with ui.element("div").classes("stack story"):
            self._first()
            self._others()
            self._fourth()
            self.last = ui.element("div").classes("stack")
        self.show()

    def show(self) -> None:
        """Draw the latest answer on the way to the present effects."""
        if (found := self._state.present) is not None and found is not self._shown:
            self._shown = found
            self._film.take(found["paths"])
            self._where.take(found["findings"])
            seen = self._seen(found)
            self._effect = seen[0]["effect"] if seen else ""
            if self._effect:
                self._state.ask_trial(self._effect)
            self._after = None
            self._first.refresh()
            self._fourth.refresh()
            self._is_behind = True

    def rank(self) -> None:
        """Draw the other steps where they are behind: of an earlier answer, or without a trial."""
        fitted = self._effect and self._waits != self._state.tries(self._effect)
        if self._is_behind or fitted:
            self._draw()

    def look_at(self, place: str) -> None:
        """Show in step 2 what errs most in a place, as a hint names it."""
        self._where.look_at(place)
        ui.run_javascript(into_view(2))

    def _film_chosen(self) -> None:
        """Ring the shot of the film among the points, unless they are drawn anew anyway."""
        if not self._is_behind:
            self._where.ring()

    def _to_film(self, shot: int) -> None:
        self._film.choose(shot)
        ui.run_javascript(into_view(1))

    def _try(self, effect: str) -> None:
        self._effect = effect
        self._state.ask_trial(effect)
        self._draw()

    def _draw(self) -> None:
        self._is_behind = False
        self._after = self._state.tried(self._effect) if self._effect else None
        self._waits = self._state.tries(self._effect)
        self._others.refresh()
        if self._after is not None:
            self._fourth.refresh()

    def _seen(self, found: Json) -> list[Json]:
        return [c for c in found["candidates"] if c["seen"] and c["effect"] not in found["with"]]

    @ui.refreshable_method
    def _first(self) -> None:
        found = self._shown
        if found is None:
            return
        self._rail(found, found["findings"][0])
        with _step(1, "Compare"):
            _lede(compared(found), "story-compare")
            with ui.element("div").classes("columns compared"):
                self._film.place()
                with ui.element("div").classes("stack"):
                    ui.label("How wrong, for each thing that is measured").classes("strong")
                    _bars(failing(found)[:BARS], estimated=bool(found.get("estimated")))
                    _counted(failing(found))
                    law(found)

    @ui.refreshable_method
    def _others(self) -> None:
        found = self._shown
        if found is None:
            return
        with _step(2, "Where it fails"):
            self._where.place()
        with _step(3, "What is missing"):
            self._missing(found, found["findings"][0])

    @ui.refreshable_method
    def _fourth(self) -> None:
        if (found := self._shown) is not None:
            with _step(4, "Add it"):
                self._added(found)

    def _rail(self, found: Json, cell: Json) -> None:
        """Place the four steps, each with its result in some words and a link to it."""
        worst, path = failing(found)[0], self._state.path()
        standing = self._state.standing
        fails = standing is not None and standing.is_open
        first, last = Unseen.of(path[0]), Unseen.of(path[-1])
        results = (
            ("Compare", _worst_of(found, worst)),
            ("Where it fails", goes_with(cell) if fails else "nowhere"),
            ("What is missing", in_plain(missing_words(standing))),
            ("Add it", f"{first.said()} → {last.said()}" if len(path) > 1 else "not yet"),
        )
        with ui.element("nav").classes("rail").props('aria-label="steps"'):
            for number, (name, result) in enumerate(results, start=1):
                done = number < 4 or len(path) > 1
                look = "stop-by done" if done else "stop-by"
                with ui.link(target=f"#step-{number}").classes(look):
                    ui.label(str(number)).classes("step-number").props("aria-hidden=true")
                    with ui.element("div"):
                        ui.label(name).classes("strong")
                        ui.label(result).classes("note")

    def _missing(self, found: Json, cell: Json) -> None:
        known, seen, standing = described(found), self._seen(found), self._state.standing
        if not self._effect:
            _lede("No effect that is known would change anything in these shots.", "story-missing")
            return
        lede = (
            "Move the slider until the line lies on the dots."
            if standing is not None and standing.missing
            else f"None of {len(seen)} effects stands out. The best of them:"
        )
        _lede(lede, "story-missing")
        fits = found, self._after
        lead_card(known[self._effect], fits, cell, self._add, self._wait)
        like: list[str] = next((c["like"] for c in seen if c["effect"] == self._effect), [])
        alike = [c for c in seen if c["effect"] in like]
        others = [c for c in seen if c not in alike and c["effect"] != self._effect][:OTHERS]
        if alike:
            with ui.element("div").classes("bracket").props("data-testid=look-alikes"):
                ui.label("Look-alikes: they do the same to these shots.").classes("strong")
                ui.label(
                    "They bend the points in almost the same way. What tells each apart stands "
                    "below it."
                ).classes("note")
                self._cards(alike, found)
        ui.label(f"Also looked at, of {len(seen)} effects").classes("strong")
        self._cards(others, found)
        left_out(found)

    def _wait(self) -> bool:
        """Place what is said while the effect is fitted; say whether it is."""
        if not self._waits:
            return False
        title = "Fitting it in full, the slider comes with the answer"
        Waiting(self._desk, title, lambda: self._waits, "trying")
        return True

    def _cards(self, candidates: Sequence[Json], found: Json) -> None:
        known, error = described(found), Unseen.of(found)
        with ui.element("div").classes("cards"):
            for candidate in candidates:
                card = card_of(known[candidate["effect"]])
                with ui.element("div").classes("card"):
                    drawing(card)
                    ui.label(card.title).classes("strong")
                    ui.label(card.notice).classes("note")
                    if error.floor is not None and error.value <= AT_THE_FLOOR:
                        ui.label("the error would hardly change").classes("note")
                    elif error.floor is not None:
                        falls = falls_to(found, candidate)
                        share = 1.0 - (falls.value - 1.0) / max(error.value - 1.0, 1e-9)
                        with ui.element("div").classes("track").props("aria-hidden=true"):
                            bar = ui.element("div").classes("bar")
                            bar.style(f"width: {100 * max(0.0, min(1.0, share)):.0f}%")
                        ui.label(f"error would fall to about {falls.said()}").classes("note")
                    look = button(
                        "Look at it",
                        lambda name=card.effect: self._try(name),
                        testid=f"try-{card.effect}",
                    )
                    look.props(f'aria-label="Look at {card.title}"')

    def _added(self, found: Json) -> None:
        path = self._state.path()
        if found["with"] and len(path) > 1:
            before, after = path[-2], path[-1]
            title = card_of(described(found)[found["with"][-1]]).title
            _lede(_fell(title, Unseen.of(before), Unseen.of(after)), "story-added")
            _changed(before, after)
        else:
            ui.label(
                "Nothing is added yet. “Add it” in step 3 puts the effect into the model and fits "
                "all of it anew."
            ).classes("lede")
        labels = ["model", *(f"+ {in_plain(name)}" for name in found["with"])][: len(path)]
        errors = [Unseen.of(stage) for stage in path]
        tried = None if self._after is None else Unseen.of(self._after)
        plot(staircase(labels, errors, tried)).props("data-testid=staircase")
        floor = "" if errors[0].floor is None else "Green: the floor, the noise itself. "
        looked = "" if tried is None else "Grey: the effect that is looked at in step 3, if added."
        ui.label(f"{floor}{looked}").classes("note")
        if self._state.effects:
            with ui.element("div").classes("beside"):
                button("Undo", lambda: self._take(self._state.effects[:-1]), testid="undo")

    def _add(self, name: str) -> None:
        self._take((*self._state.effects, name))


def _worst_of(found: Json, worst: Json) -> str:
    """Return how wrong the worst quantity is, in some words."""
    if found.get("estimated"):
        return f"off by {worst['size']:.3g} {worst['unit']}"
    if worst["p_familywise"] >= SURE:
        return "within the noise"
    times = three_figures(worst["error"])
    return f"off by {worst['size']:.3g} {worst['unit']}, {times} × the noise"


def _fell(title: str, before: Unseen, after: Unseen) -> str:
    """Return what adding an effect did to the error."""
    lead = f"With “{title}” the error on shots that the model has not seen goes from "
    if after.floor is None:
        return f"{lead}{before.said()} to {after.said()}."
    told = f"{lead}{three_figures(before.value)} to {three_figures(after.value)} times the noise"
    if after.value <= AT_THE_FLOOR:
        return f"{told}. Nothing can do better: this is the floor."
    return f"{told}; the floor is 1.00."


def _changed(before: Json, after: Json) -> None:
    """Place the points without and with the effect beside each other, on the same axes."""
    shown = plainest(before, after)
    if shown is None:
        return
    cell, first, second = shown
    first, second = apart(first), apart(second)
    row = channel(cell["channel"])
    with ui.element("div").classes("columns half"):
        with ui.element("div"):
            ui.label(f"Before: the {row}").classes("strong fails")
            plot(before_after(cell, first, None))
        with ui.element("div"):
            ui.label("After, on the same axes").classes("strong chosen")
            plot(before_after(cell, first, second)).props("data-testid=after")


def _step(number: int, title: str) -> ui.element:
    panel = ui.element("section").classes("panel step-panel").props(f"id=step-{number} tabindex=-1")
    with panel, ui.element("div").classes("title"):
        ui.label(str(number)).classes("step-number").props("aria-hidden=true")
        ui.html(escape(title), sanitize=False, tag="h3")
    return panel


def _lede(text: str, testid: str) -> None:
    ui.label(text).classes("lede").props(f"data-testid={testid}")


def _bars(rows: Sequence[Json], *, estimated: bool) -> None:
    if estimated:
        # As multiples of a scatter that is taken for the noise all errors would be about 1.
        for row in rows:
            ui.label(f"{channel(row['quantity'])}: {row['size']:.3g} {row['unit']}").classes(
                "strong"
            )
        return
    # From the floor on, in steps of equal ratio: nothing is drawn for what is only noise.
    most = math.log(max(LEAST_SPAN, *(row["error"] for row in rows)))
    bars(
        [
            Bar(
                channel(row["quantity"]),
                math.log(max(1.0, row["error"])) / most,
                f"{three_figures(row['error'])} ×",
                fails=row["p_familywise"] < SURE,
                beside=f"{row['size']:.3g} {row['unit']}",
            )
            for row in rows
        ]
    )


def _counted(rows: Sequence[Json]) -> None:
    """Say how many quantities disagree, and how the bars are read."""
    wrong = sum(row["p_familywise"] < SURE for row in rows)
    ui.label(
        f"{wrong} of {len(rows)} quantities disagree. Error on shots that the model has not seen, "
        "as a multiple of the noise; bars begin at 1, the floor. Green may be chance alone."
    ).classes("note")
