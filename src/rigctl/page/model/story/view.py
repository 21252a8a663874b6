"""The story: compare, where it fails, what is missing, add; each with its result in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape

from nicegui import ui

from analysis.model.verdict.standing import (
    WORTH,
    Standing,
    Word,
    standing_of,
)
from rigctl.documents import Json
from rigctl.page.desk import Desk
from rigctl.page.model.effect_words import described, left_out
from rigctl.page.model.state import Effects, ModelState
from rigctl.page.model.story.answers import (
    came_back,
    changed,
    counted,
    counts_here,
    error_bars,
    fell,
    is_sure,
    law,
    learnt,
    others,
    place_learnt,
    size_of,
    worst_of,
)
from rigctl.page.model.story.cards import card_of, in_plain
from rigctl.page.model.story.errors import Unseen
from rigctl.page.model.story.ghost import ShotFilm
from rigctl.page.model.story.lead import lead_card
from rigctl.page.model.story.plots import staircase
from rigctl.page.model.story.preview import plainest
from rigctl.page.model.story.where import PLACES, WhereItFails, cause_first
from rigctl.page.model.story.words import (
    compared,
    failing,
    fails_where,
    missing_words,
)
from rigctl.page.parts.choosing import Choice
from rigctl.page.parts.keys import to_step
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button, plot

BARS = 8


class Story:
    """Four steps, drawn anew with each answer; `take` has the model taken with other effects.

    Of the first answer step 1 is drawn at once, of a later one step 4, where it was asked for; the
    others with `rank`: a browser needs a second for all of them.
    `last` is where more can be placed after them.
    """

    def __init__(self, desk: Desk, state: ModelState, take: Callable[[Effects], None]) -> None:
        self._desk, self._state, self._take = desk, state, take
        self._shown: Json | None = None
        self._fits: tuple[Json, Json] | None = None
        self._standing: Standing | None = None
        self._effect, self._waits = "", ""
        self._is_behind = self._is_before = False
        self._goes_to: int | None = None
        self._known, self._late = 0, self._fourth
        self._turners: dict[int, Choice[bool]] = {}
        self._film = ShotFilm(desk, state, self._film_chosen)
        self._where = WhereItFails(self._to_film, lambda: self._film.shot)
        with ui.element("div").classes("stack story"):
            with ui.element("div").classes("stack") as self._steps:
                self._rail()
                parts = self._first, self._second, self._third, self._fourth
                for number, part in enumerate(parts, start=1):
                    # The section stays, and with it the focus; what it holds is drawn anew.
                    section = ui.element("section").classes("panel step-panel")
                    with section.props(f"id=step-{number} tabindex=-1"):
                        part()
            self.last = ui.element("div").classes("stack")
        self.show()

    def show(self) -> None:
        """Draw the answer with the present effects; where there will be none, the one before it."""
        found, path = self._state.present, self._state.path()
        if found is None and self._state.failure and path:
            found = path[-1]
        self._steps.set_visibility(found is not None or self._shown is not None)
        known, self._known = self._known, len(path)
        stood, self._standing = self._standing, self._state.standing
        if found is not None and found is self._shown and known == len(path):
            if stood != self._standing:
                self._stands_anew()
        elif found is not None:
            # A reloaded page may hear of the model with an effect before it hears of it without.
            opens = self._shown is None
            self._shown, self._is_before = found, False
            self._look_at_stage()
            seen = self._seen(found) if found is self._state.present else []
            standing = self._state.standing
            # What the verdict names is looked at; another may lead the list without standing out.
            named = () if standing is None else standing.missing
            self._effect = next(iter((*named, *(one["effect"] for one in seen))), "")
            if self._effect and not (standing is not None and standing.word is Word.FLOOR):
                self._state.ask_trial(self._effect)
            self._fits = None
            self._rail.refresh()
            now, self._late = self._first, self._fourth
            if not opens:
                now, self._late = self._late, now
            now.refresh()
            self._is_behind = True

    def _stands_anew(self) -> None:
        """Draw what a trial or the whole way has changed: what is missing, not what was measured.

        The effect that is looked at stays.
        """
        self._look_at_stage()
        self._rail.refresh()
        self._compared.refresh()
        self._failing.refresh()
        self._draw()

    def rank(self) -> None:
        """Draw the other steps where they are behind: of an earlier answer, or without a trial."""
        fitted = self._effect and self._waits != self._state.tries(self._effect)
        if self._is_behind:
            self._is_behind = False
            self._late.refresh()
            self._second.refresh()
            self._draw()
            if self._goes_to is not None:
                # What stands above it has been drawn anew, and is not as high as it was.
                ui.run_javascript(to_step(self._goes_to))
                self._goes_to = None
        elif fitted:
            self._draw()

    def turn(self, *, before: bool) -> None:
        """Show steps 1 and 2 as they were before the last effect was added, or with it."""
        self._is_before = before
        for turner in self._turners.values():
            turner.press(before)
        self._look_at_stage()
        self._compared.refresh()
        self._failing.refresh()

    @property
    def _stages(self) -> list[Json]:
        """The answers on the way to the one that steps 1 and 2 show."""
        path = self._state.path()
        return path[:-1] if self._is_before and len(path) > 1 else path

    def _look_at_stage(self) -> None:
        stages = self._stages
        found, standing = stages[-1], self._stands(stages)
        self._film.take(found["paths"], tuple(found["with"]))
        self._where.take(cause_first(found, standing), standing)

    def _stands(self, stages: Sequence[Json]) -> Standing:
        """Return how the last of some stages stands; what came later says nothing of the others."""
        if self._is_before:
            return standing_of(stages)
        return standing_of(stages, self._state.concluded, self._state.trials())

    def look_at(self, place: str) -> None:
        """Show in step 2 what errs most in a place, as a hint names it."""
        self._where.look_at(place)
        ui.run_javascript(to_step(2))

    def _film_chosen(self) -> None:
        """Ring the shot of the film among the points, unless they are drawn anew anyway."""
        if not self._is_behind:
            self._where.ring()

    def _to_film(self, shot: int) -> None:
        self._film.choose(shot)
        ui.run_javascript(to_step(1))

    def _try(self, effect: str) -> None:
        self._effect = effect
        self._state.ask_trial(effect)
        self._draw()
        # The button that was pressed is gone, and the focus with it.
        ui.run_javascript(to_step(3))

    def _draw(self) -> None:
        self._fits = self._state.tried(self._effect) if self._effect else None
        self._waits = self._state.tries(self._effect)
        self._third.refresh()
        if self._fits is not None:
            self._fourth.refresh()

    def _seen(self, found: Json) -> list[Json]:
        return [c for c in found["candidates"] if c["seen"] and c["effect"] not in found["with"]]

    @ui.refreshable_method
    def _first(self) -> None:
        if self._shown is not None:
            self._title(1, "Compare", lambda: self._turner(1))
            self._compared()

    @ui.refreshable_method
    def _compared(self) -> None:
        stages = self._stages
        found = stages[-1]
        _lede(compared(found, self._stands(stages)), "story-compare")
        with ui.element("div").classes("columns compared"):
            self._film.place()
            with ui.element("div").classes("stack"):
                ui.label("How wrong, for each thing that is measured").classes("strong")
                error_bars(failing(found)[:BARS], estimated=bool(found.get("estimated")))
                counted(failing(found))
                law(found, stages[-2] if len(stages) > 1 else None)

    @ui.refreshable_method
    def _second(self) -> None:
        if self._shown is not None:
            self._title(2, "Where it fails", lambda: self._turner(2))
            self._failing()

    @ui.refreshable_method
    def _failing(self) -> None:
        self._where.place()

    @ui.refreshable_method
    def _third(self) -> None:
        if (found := self._shown) is not None:
            self._title(3, "What is missing")
            self._missing(found)

    @ui.refreshable_method
    def _fourth(self) -> None:
        if (found := self._shown) is not None:
            self._title(4, "Add it", self._undoer)
            self._added(found)

    def _title(self, number: int, title: str, beside: Callable[[], None] | None = None) -> None:
        with ui.element("div").classes("title"):
            ui.label(str(number)).classes("step-number").props("aria-hidden=true")
            ui.html(escape(title), sanitize=False, tag="h3")
            if beside is not None:
                beside()

    def _undoer(self) -> None:
        if self._state.effects:
            ui.space()
            button("Undo", lambda: self._take(self._state.effects[:-1]), testid="undo")

    def _turner(self, number: int) -> None:
        """Place the switch between before and after, once an effect is added."""
        self._turners.pop(number, None)
        if len(self._state.path()) < 2:
            return
        ui.space()
        words = {True: "before adding", False: "after"}
        self._turners[number] = Choice(
            "before or after", words, self._is_before, lambda before: self.turn(before=before)
        )

    @ui.refreshable_method
    def _rail(self) -> None:
        """Place the four steps, each with its result in some words and a link to it."""
        if (found := self._shown) is None:
            return
        worst, path = failing(found)[0], self._state.path()
        standing = self._state.standing
        fails = standing is not None and standing.is_open
        first, last = Unseen.of(path[0]), Unseen.of(path[-1])
        results = (
            ("Compare", worst_of(found, worst)),
            ("Where it fails", fails_where(cause_first(found, standing)) if fails else "nowhere"),
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

    def _missing(self, found: Json) -> None:
        known, seen, standing = described(found), self._seen(found), self._state.standing
        if not self._effect:
            _lede("No effect that is known would change anything in these shots.", "story-missing")
            return
        lede = f"None of {len(seen)} effects stands out. The best of them:"
        if standing is not None and standing.missing:
            lede = "Move the slider: the line among the dots and the error follow."
        elif standing is not None and standing.word is Word.UNEXPLAINED:
            lede = f"None of {len(seen)} effects explains it. The best of them:"
        if self._nothing_is_left():
            nothing = f"Nothing is left to add: none of {len(seen)} effects stands out."
            _lede(nothing, "story-missing")
            with ui.element("details").props("data-testid=nearest") as folded:
                ui.html("Look at those that come nearest", sanitize=False, tag="summary")
                self._looked_at(found, known, seen)
            folded.props("open" if self._state.has_tried(self._effect) else "")
            return
        _lede(lede, "story-missing")
        self._looked_at(found, known, seen)

    def _nothing_is_left(self) -> bool:
        """Whether something was added, and the model is at its floor."""
        standing = self._state.standing
        return bool(self._state.effects) and standing is not None and standing.word is Word.FLOOR

    def _looked_at(self, found: Json, known: dict[str, Json], seen: Sequence[Json]) -> None:
        """Place the effect that is looked at, its look-alikes and some others."""
        lead_card(known[self._effect], self._fits or (found, None), self._add, self._wait)
        if self._fits is not None:
            back = sorted(set(found["rejected"]) - set(self._fits[0]["rejected"]))
            if back:
                said = counts_here(back, Unseen.of(found), Unseen.of(self._fits[0]))
                ui.label(said).classes("note").props("data-testid=counts-here")
        others(known, found, seen, self._effect, self._try)
        left_out(found)

    def _wait(self) -> bool:
        """Place what is said while the effect is fitted, or a button for it where nothing asks it.

        False where the fit has been and gave no size.
        """
        if not self._waits:
            if self._state.has_tried(self._effect):
                return False
            button("Fit it in full", lambda: self._try(self._effect), testid="fit-in-full")
            return True
        title = "Fitting it in full, the slider comes with the answer"
        Waiting(self._desk, title, lambda: self._waits, "trying", in_plain)
        return True

    def _added(self, found: Json) -> None:
        path = self._state.path()
        if found["with"] and len(path) > 1:
            before, after = path[-2], path[-1]
            effect = described(found)[found["with"][-1]]
            card = card_of(effect)
            _lede(fell(card.title, Unseen.of(before), Unseen.of(after)), "story-added")
            shown = plainest(before, after, PLACES.get(card.where, ""))
            if shown is not None:
                changed(shown)
            if back := self._state.come_back():
                ui.label(came_back(back, same=self._state.is_of_the_same_shots)).classes(
                    "note"
                ).props("data-testid=came-back")
            lowers = after["prediction_error"] < WORTH * before["prediction_error"]
            if lowers or is_sure(size_of(effect, after)):
                mechanism, evidence = learnt(effect, before, after, shown)
                place_learnt(card.title, mechanism, evidence, self._as_well(found))
        else:
            ui.label(
                "Nothing is added yet. “Add it” in step 3 puts the effect into the model and fits "
                "all of it anew."
            ).classes("lede")
        labels = ["model", *(f"+ {in_plain(name)}" for name in found["with"])][: len(path)]
        errors = [Unseen.of(stage) for stage in path]
        tried = None if self._fits is None else Unseen.of(self._fits[1])
        if self._fits is not None and path[-1] is found:
            # Both of the same shots: with the effect some may fit that are left out without it.
            errors[-1] = Unseen.of(self._fits[0])
        plot(staircase(labels, errors, tried)).props("data-testid=staircase")
        floor = "" if errors[0].floor is None else "Green: the floor, the noise itself. "
        looked = "" if tried is None else "Grey: the effect that is looked at in step 3, if added."
        ui.label(f"{floor}{looked}").classes("note")

    def _as_well(self, found: Json) -> str:
        """Return the effect that would have done as well as the one that was added; empty: none."""
        standing = self._state.standing
        pair = () if standing is None or standing.word is not Word.ALIKE else standing.tell or ()
        return next((name for name in pair if name not in found["with"]), "")

    def _add(self, name: str) -> None:
        self._goes_to = 4
        self._take((*self._state.effects, name))
        ui.run_javascript(to_step(4))


def _lede(text: str, testid: str) -> None:
    ui.label(text).classes("lede").props(f"data-testid={testid}")
