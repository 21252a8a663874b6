"""A challenge on the page: answered once and for all, and revealed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import Any

from nicegui import ui

from rigctl import challenge, game
from rigctl.errors import RigError
from rigctl.game import Clue
from rigctl.model.known_effects import ALL_EFFECTS, effect_document
from rigctl.page.model.state import ModelState
from rigctl.page.model.story.cards import Card, card_of, named
from rigctl.page.model.story.lead import drawing, sentence_of
from rigctl.page.model.story.where import PLACES
from rigctl.page.parts.asking import ask_again
from rigctl.page.parts.tables import Line, facts, minus, with_error
from rigctl.page.parts.widgets import button

Json = Mapping[str, Any]
OUTCOMES = {
    "right": "Right.",
    "alias": "As good as right: these shots cannot tell your answer from the truth.",
    "partly": "Partly right.",
    "wrong": "Wrong.",
}
NOTHING = {"none": "Nothing", "unexplained": "Something that is in no catalogue"}


def in_titles(names: Sequence[str]) -> str:
    """Return the names of an answer in words."""
    known = cards()
    titles = {name: f"“{card.title}”" for name, card in known.items()} | NOTHING
    return " and ".join(titles.get(name, name) for name in names)


def cards() -> dict[str, Card]:
    """Return the cards of the effects of the catalogue by their names."""
    return {effect.name: card_of(effect_document(effect)) for effect in ALL_EFFECTS}


def clues() -> dict[str, Clue]:
    """Return what hints take from the cards."""
    return {name: Clue(card.where, card.notice) for name, card in cards().items()}


def reveal_beside(
    label: challenge.Label,
    answer: Sequence[str],
    outcome: challenge.Outcome,
    fitted: Mapping[str, Json],
    played: game.Game | None = None,
) -> None:
    """Place the outcome with its points, and side by side what was hidden and what was answered.

    Parameters
    ----------
    fitted
        Parameters of the fit by `effect.symbol`, in the catalogue's order.
    played
        The game; None where it is played without points.
    """
    look = "good" if outcome in {"right", "alias"} else "bad"
    with ui.element("div").classes(f"verdict {look}").props("data-testid=truth"):
        ui.label(OUTCOMES[outcome]).classes("lead")
        ui.label(f"The truth is: {in_titles(label.answer)}.")
    if played is not None:
        score_of(played, game.score(played, outcome))
    known = cards()
    bounce = fitted.get("e", {}).get("value") or 0.0
    with ui.element("div").classes("columns half").props("data-testid=side-by-side"):
        with _side("What was hidden"):
            for one in label.effects:
                _entry(known.get(one.effect), one.effect, hidden_size(one, bounce))
            if not label.effects:
                _entry(None, NOTHING["none"], "")
        with _side("Your answer"):
            for name in answer:
                _entry(
                    known.get(name), NOTHING.get(name, name), _found(name, label, fitted, bounce)
                )
    ui.label("The label is the one that was sealed when the campaign was made.").classes("note")


def _side(title: str) -> ui.element:
    side = ui.element("section").classes("panel")
    with side:
        ui.html(escape(title), sanitize=False, tag="h3").classes("card-heading")
    return side


def _entry(card: Card | None, name: str, size: str) -> None:
    with ui.element("div").classes("revealed"):
        if card is not None:
            drawing(card)
        with ui.element("div").classes("stack"):
            ui.label(name if card is None else card.title).classes("strong")
            if card is not None:
                ui.label(card.what).classes("note")
            if size:
                ui.label(size)


def hidden_size(one: challenge.HiddenEffect, bounce: float) -> str:
    """Return what a hidden effect does, and its size; where no sentence is known what it is."""
    unit = "" if one.unit == "1" else f" {one.unit}"
    size, does = f"{one.amplitude:.4g}{unit}", sentence_of(one.effect, one.amplitude, bounce)
    return minus(f"{does} Size: {size}." if does else f"Size: {size} ({one.meaning}).")


def _found(name: str, label: challenge.Label, fitted: Mapping[str, Json], bounce: float) -> str:
    """Return what an answered effect does by the fit, its size, and how far it is off."""
    hidden = next((one for one in label.effects if one.effect == name), None)
    found = next((fitted[key] for key in fitted if key.startswith(f"{name}.")), None)
    if found is None:
        return "" if name in NOTHING else "Not in the model that is fitted: no size."
    does = "" if found["value"] is None else f"{sentence_of(name, found['value'], bounce)} "
    if hidden is None:
        return f"{does}Fitted size: {with_error(found)}.".lstrip()
    size, apart = beside_truth(hidden, fitted)
    off = f", {apart} from the truth" if apart else ""
    return f"{does}Fitted size: {size}{off}.".lstrip()


def beside_truth(
    hidden: challenge.HiddenEffect, fitted: Mapping[str, Mapping[str, Any]]
) -> tuple[str, str]:
    """Return the fitted size of a hidden effect, and by how many standard errors it is off.

    Parameters
    ----------
    fitted
        Parameters of the fit by `effect.symbol`, in the catalogue's order.
    """
    first = next((fitted[name] for name in fitted if name.startswith(f"{hidden.effect}.")), None)
    if first is None:
        return "not added", ""
    sigma = first.get("sigma")
    if first["value"] is None or not sigma:
        return with_error(first), ""
    return with_error(first), f"{abs(first['value'] - hidden.amplitude) / sigma:.1f} σ"


HINTS = ("How much is hidden?", "Where to look?", "What to look for?")


class ChallengePanel:
    """Answer and truth of the challenge that a source is; nothing for any other source.

    The truth stands beside what the fit with the most effects so far says.

    Parameters
    ----------
    look
        Shows the most striking cell of a place such as `at the bounce`; None: nothing can.
    """

    def __init__(self, state: ModelState, look: Callable[[str], None] | None = None) -> None:
        self._state, self._look = state, look
        self._folder = state.source.folder
        self._game = None if self._folder is None else game.game_of(self._folder)
        self._given: ui.select | None = None
        self._filled: list[str] = []
        if self._folder is not None and (self._folder / challenge.PUBLIC).is_file():
            with ui.element("div").classes("panel").props("data-testid=challenge"):
                self._show()

    @ui.refreshable_method
    def _show(self) -> None:
        ui.label("This campaign is a challenge").classes("title")
        if self._folder is not None and (self._folder / challenge.ANSWER).is_file():
            self._answered()
        else:
            self._open()

    def _open(self) -> None:
        hidden = (
            "Something is hidden in it, or nothing."
            if self._game is None or self._game.level not in game.COUNTED
            else "Something is hidden in it."
        )
        ui.label(
            f"{hidden} Name it: the answer is written once and never changed. Then the seal can "
            "be broken."
        ).classes("note")
        with ui.element("div").classes("stack"):
            self._hint()
        self._filled = answer_from(self._state.effects)
        names = choices(self._game)
        with ui.element("div").classes("beside"):
            given = ui.select(
                names,
                multiple=True,
                value=list(self._filled),
                label="What is hidden?",
                with_input=True,
            )
            self._given = given
            given.props("outlined dense use-chips data-testid=answer").style(
                "min-width: min(420px, 100%)"
            )
            if self._game is not None:
                sure = {value: f"{value:.0%} sure" for value in game.SURE}
                self._sure = _choice("How sure?", sure, game.SURE[0], "sure")
            commit = button(
                "Commit …", lambda: self._ask(list(given.value)), look="fill", testid="commit"
            )
            commit.bind_enabled_from(given, "value", bool)

    def follow(self) -> None:
        """Fill in what was added to the model, unless somebody has changed the answer by hand."""
        if self._given is None or list(self._given.value) != self._filled:
            return
        self._filled = answer_from(self._state.effects)
        self._given.set_value(list(self._filled))

    @ui.refreshable_method
    def _hint(self) -> None:
        """Show the hints that were taken, and offer the next one for points.

        The answer below stays as far as it is given.
        """
        if self._game is None or self._folder is None:
            return
        ui.label(
            f"Level {self._game.level}: {game.LEVELS[self._game.level - 1]}. "
            f"{self._game.shots} shots."
        ).props("data-testid=game")
        for said in game.hints(self._folder, self._game, clues()):
            ui.label(f"Hint: {said}").props("data-testid=hint")
        if self._look is not None:
            for place in game.places(self._folder, self._game, clues()):
                self._look_button(place, self._look)
        if left := self._game.offered[self._game.hints :]:
            words = f"{HINTS[left[0]]} A hint for {game.HINT_COSTS[left[0]]} points"
            button(words, self._take_hint, testid="take-hint")

    @staticmethod
    def _look_button(place: str, look: Callable[[str], None]) -> None:
        if place in PLACES:
            button(f"Show what errs most {place}", lambda: look(place), testid="show-hint")

    def _take_hint(self) -> None:
        if self._game is None or self._folder is None:
            return
        try:
            self._game = game.take_hint(self._folder, self._game)
        except RigError as error:
            ui.notify(error.sentence(), type="negative", multi_line=True)
            return
        self._hint.refresh()

    def _answered(self) -> None:
        if self._folder is None:
            return
        try:
            label, answer, outcome = challenge.reveal(self._folder)
        except RigError as error:
            ui.label(error.sentence()).classes("verdict bad")
            return
        ui.label(f"You committed to: {in_titles(answer)}.")
        truth = ui.element("div")

        def reveal() -> None:
            # Nothing of it is in the page before.
            fitted = (self._state.path() or [{}])[-1].get("parameters", {})
            with truth.classes("stack"):
                reveal_beside(label, answer, outcome, fitted, self._game)
            breaking.set_visibility(False)
            ui.run_javascript(f"getHtmlElement({truth.id}).scrollIntoView()")

        breaking = button("Break the seal", reveal, look="fill", testid="reveal")

    def _ask(self, names: list[str]) -> None:
        sure = None if self._game is None else float(self._sure.value)
        ask_again(
            question(names, sure),
            "The answer is written once: it can neither be changed nor taken back.",
            "Commit",
            lambda: self._commit(names),
        )

    def _commit(self, names: list[str]) -> None:
        if self._folder is None:
            return
        known = [effect.name for effect in ALL_EFFECTS]
        try:
            challenge.commit(self._folder, ",".join(names), known=known)
            if self._game is not None:
                self._game = game.be_sure(self._folder, self._game, float(self._sure.value))
        except RigError as error:
            ui.notify(error.sentence(), type="negative", multi_line=True)
            return
        self._given = None
        self._show.refresh()


def choices(played: game.Game | None) -> dict[str, str]:
    """Return what an answer may name; a level that hides known effects offers them alone."""
    known = {effect.name: named(effect.name) for effect in ALL_EFFECTS}
    if played is not None and played.level in game.COUNTED:
        return known
    return {name: f"{NOTHING[name]} ({name})" for name in challenge.ALONE} | known


def answer_from(effects: Sequence[str]) -> list[str]:
    """Return the effects that were added as far as an answer may name them."""
    known = {effect.name for effect in ALL_EFFECTS}
    return [name for name in effects if name in known]


def question(names: Sequence[str], sure: float | None) -> str:
    """Return what is asked before the answer is written."""
    how = "" if sure is None else f", {100 * sure:.0f} % sure"
    return f"Commit to {in_titles(names)}{how}?"


def _choice(label: str, options: Mapping[Any, str], value: object, testid: str) -> ui.select:
    placed = ui.select(dict(options), value=value, label=label)
    placed.props(f'outlined dense options-dense data-testid={testid} aria-label="{label}"')
    return placed.style("min-width: min(220px, 100%)")


def score_of(played: game.Game, points: game.Score) -> None:
    """Place the points and where they come from."""
    sure = "not said" if played.sure is None else f"{played.sure:.0%}"
    lines = [
        Line(["what was found", f"{points.found:+d}"]),
        Line([f"with {played.shots} shots", f"{points.few:+d}"]),
        Line([f"hints: {played.hints}", f"{points.hints:+d}"]),
        Line([f"sure: {sure}", f"{points.sure:+d}"]),
        Line(["all together", f"{points.total:+d}"]),
    ]
    ui.label(f"Level {played.level}, {points.total} points").classes("strong").props(
        "data-testid=score"
    )
    facts(["", "points"], [Line([minus(str(cell)) for cell in line.cells]) for line in lines])
