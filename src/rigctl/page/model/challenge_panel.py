"""A challenge on the page: made, answered once and for all, and revealed."""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from typing import Any

from nicegui import ui

from rigctl import challenge
from rigctl.errors import RigError
from rigctl.model.known_effects import ALL_EFFECTS
from rigctl.page.desk import Desk
from rigctl.page.model.source import Source
from rigctl.page.model.state import ModelState
from rigctl.page.parts.asking import ask_again
from rigctl.page.parts.tables import Cell, Line, facts, minus, with_error
from rigctl.page.parts.widgets import button

FOLDER = "challenges"
"""Folder of the challenges made here, inside the store's."""
SHOTS = 120
OUTCOMES = {
    "right": "Right.",
    "alias": "As good as right: these shots cannot tell your answer from the truth.",
    "partly": "Partly right.",
    "wrong": "Wrong.",
}


def challenge_maker(desk: Desk) -> None:
    """Place the panel that makes a challenge and lists those that were made."""
    store = desk.daemon.store.path / FOLDER

    async def make() -> None:
        folder = store / f"challenge-{secrets.token_hex(3)}"

        def work() -> bool:
            store.mkdir(parents=True, exist_ok=True)
            challenge.new(folder, seed=None, strength=str(strength.value), shots=SHOTS)
            return True

        if await desk.act(work):
            ui.navigate.to(Source.of_folder(desk.daemon, str(folder)).address)

    with ui.element("div").classes("panel"):
        ui.label("Take a challenge").classes("title")
        ui.label(
            f"{SHOTS} shots of a laboratory that hides something: one effect, two, or none. Find "
            "it, commit to an answer, and break the seal."
        ).classes("note")
        with ui.element("div").classes("beside"):
            strength = ui.radio({"full": "as strong as on a rig", "quarter": "a quarter of it"})
            strength.set_value("full")
            strength.props("inline dense")
            button("Make one", make, look="fill", testid="new-challenge")
        for made in sorted(store.glob("*/campaign.toml")) if store.is_dir() else ():
            ui.link(made.parent.name, Source.of_folder(desk.daemon, str(made.parent)).address)


class ChallengePanel:
    """Answer and truth of the challenge that a source is; nothing for any other source.

    The truth stands beside what the fit with the most effects so far says.
    """

    def __init__(self, state: ModelState) -> None:
        self._state = state
        self._folder = state.source.folder
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
        ui.label(
            "Something is hidden in it, or nothing. Name it: the answer is written once and never "
            "changed. Then the seal can be broken."
        ).classes("note")
        names = [*challenge.ALONE, *sorted(effect.name for effect in ALL_EFFECTS)]
        with ui.element("div").classes("beside"):
            given = ui.select(names, multiple=True, label="What is hidden?", with_input=True)
            given.props("outlined dense use-chips data-testid=answer").style(
                "min-width: min(320px, 100%)"
            )
            commit = button(
                "Commit …", lambda: self._ask(list(given.value)), look="fill", testid="commit"
            )
            commit.bind_enabled_from(given, "value", bool)

    def _answered(self) -> None:
        if self._folder is None:
            return
        try:
            label, answer, outcome = challenge.reveal(self._folder)
        except RigError as error:
            ui.label(error.sentence()).classes("verdict bad")
            return
        ui.label(f"You committed to: {', '.join(answer)}.")
        truth = ui.element("div")

        def reveal() -> None:
            # Nothing of it is in the page before.
            with truth:
                _truth(label, outcome, (self._state.path() or [{}])[-1].get("parameters", {}))
            breaking.set_visibility(False)

        breaking = button("Break the seal", reveal, look="fill", testid="reveal")

    def _ask(self, names: list[str]) -> None:
        ask_again(
            f"Commit to {' and '.join(names)}?",
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
        except RigError as error:
            ui.notify(error.sentence(), type="negative", multi_line=True)
            return
        self._show.refresh()


def _truth(
    label: challenge.Label, outcome: challenge.Outcome, fitted: Mapping[str, Mapping[str, Any]]
) -> None:
    """Place what was hidden, how the answer agrees with it, and what the fit says of its size."""
    look = "good" if outcome in {"right", "alias"} else "bad"
    with ui.element("div").classes(f"verdict {look}").props("data-testid=truth"):
        ui.label(OUTCOMES[outcome]).classes("lead")
        ui.label(f"The truth is: {', '.join(label.answer)}.")
    lines = [
        Line(
            [
                one.effect,
                minus(f"{one.amplitude:.4g}"),
                *beside_truth(one, fitted),
                Cell("" if one.unit == "1" else one.unit, look="left dim"),
                Cell(one.meaning, look="left"),
            ]
        )
        for one in label.effects
    ]
    if lines:
        headings: list[Cell | str] = [
            Cell("hidden", "Effect of the catalogue that was put into the shots."),
            Cell("size", "Of its first parameter, as it was put into the shots."),
            Cell("your fit", "The same parameter as these shots say, with its standard error."),
            Cell("apart", "Difference in standard errors of the fit: below 3 they agree."),
            Cell("unit", look="left"),
            Cell("what the number says", look="left"),
        ]
        facts(headings, lines)
    ui.label("The label is the one that was sealed when the campaign was made.").classes("note")


def beside_truth(
    hidden: challenge.HiddenEffect, fitted: Mapping[str, Mapping[str, Any]]
) -> tuple[str, str]:
    """Return what a fit says of a hidden effect's size, and by how many standard errors it errs.

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
