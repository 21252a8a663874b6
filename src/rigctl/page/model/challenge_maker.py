"""Where a challenge begins: its level is chosen, and those that were made are listed."""

from __future__ import annotations

import secrets
from pathlib import Path

from nicegui import ui

from analysis.errors import counted
from rigctl import challenge, game
from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.model.source import Source
from rigctl.page.parts.choosing import Choice, press
from rigctl.page.parts.tables import minus
from rigctl.page.parts.widgets import button

FOLDER = "challenges"
"""Folder of the challenges made here, inside the store's."""
TASKS = (
    "It shows plainly in one place. A good start.",
    "Is anything hidden at all? Noise looks like something too.",
    "One hides behind the other: add the first, then look again.",
    "The first name that fits may be wrong: hold it against its look-alikes.",
    "One or two effects, none, or a law that is in no catalogue.",
    "As level 5, and hardly above the noise.",
)
"""What each level asks, in the order of `game.LEVELS`."""


class ChallengeMaker:
    """Levels as cards, numbers of shots as buttons, and the challenges made before."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._store = desk.daemon.store.path / FOLDER
        self._level, self._shots = 1, game.SHOTS[-1]
        with ui.element("div").classes("panel").props("data-testid=challenges"):
            ui.html("Take a challenge", sanitize=False, tag="h2").classes("card-heading")
            ui.label(
                "A laboratory hides something in its shots. Find it, say how sure you are, commit "
                "to an answer, and break the seal. Finding it gives 100 points; fewer shots and "
                "no hints give more, and so does being sure when you are right."
            )
            with ui.element("div").classes("levels").props('role=group aria-label="level"'):
                named = enumerate(zip(game.LEVELS, TASKS, strict=True), start=1)
                self._cards = {level: self._card(level, *words) for level, words in named}
            counts = {count: f"{count} shots, points × {game.FEW[count]:g}" for count in game.SHOTS}
            testids = {count: f"shots-{count}" for count in game.SHOTS}
            Choice("shots", counts, self._shots, self._take_shots, testids)
            self._start = button("", self._make, look="fill", testid="new-challenge")
            self._take_level(self._level)
            self._made()

    def _card(self, level: int, name: str, task: str) -> ui.element:
        card = ui.element("button").classes("level").on("click", lambda: self._take_level(level))
        card.props(f"type=button data-testid=level-{level}")
        with card:
            ui.label(str(level)).classes("step-number").props("aria-hidden=true")
            with ui.element("span").classes("stack"):
                ui.label(name).classes("strong")
                ui.label(task).classes("note")
        return card

    def _take_level(self, level: int) -> None:
        self._level = level
        for own, card in self._cards.items():
            press(card, pressed=own == level)
        self._start.set_text(f"Start level {level}")

    def _take_shots(self, shots: int) -> None:
        self._shots = shots

    async def _make(self) -> None:
        folder = self._store / f"challenge-{secrets.token_hex(3)}"

        def work() -> game.Game:
            self._store.mkdir(parents=True, exist_ok=True)
            return game.new_game(folder, level=self._level, shots=self._shots)

        if await self._desk.act(work) is not None:
            ui.navigate.to(Source.of_folder(self._desk.daemon, str(folder)).address)

    def _made(self) -> None:
        found = sorted(self._store.glob("*/campaign.toml")) if self._store.is_dir() else []
        if found:
            ui.label("Made before").classes("strong")
        for folder in (path.parent for path in found):
            with ui.element("div").classes("beside"):
                address = Source.of_folder(self._desk.daemon, str(folder)).address
                ui.link(folder.name, address)
                ui.label(standing(folder)).classes("aside")


def standing(folder: Path) -> str:
    """Say the level of a challenge, and how far its player is."""
    played = game.game_of(folder)
    level = "" if played is None else f"level {played.level}, {played.shots} shots: "
    if not (folder / challenge.ANSWER).is_file():
        taken = 0 if played is None else played.hints
        return f"{level}open" + (f", {counted(taken, 'hint')} taken" if taken else "")
    try:
        _, _, outcome = challenge.reveal(folder)
    except RigError:
        return f"{level}answered"
    if played is None:
        return f"{level}answered, {outcome}"
    return minus(f"{level}{game.score(played, outcome).total} points")
