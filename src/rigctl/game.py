"""A challenge as a game: its level, what hints cost, and the score once the seal is broken."""

from __future__ import annotations

import importlib
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Protocol, cast

from rigctl.challenge import Label, Outcome, label_of
from rigctl.errors import SettingsError, StoreError

MAKER = "simulators.challenge.levels:new_level"
"""Module and function that make a challenge of a level, loaded by name."""
FILE = "game.json"
LEVELS = (
    "One plain effect",
    "One effect, or none",
    "Two effects at once",
    "One effect that others look like",
    "Anything, also what nobody has named",
    "Anything, a quarter as strong",
)
SHOTS = (24, 60, 120)
FOUND: dict[Outcome, int] = {"right": 100, "alias": 100, "partly": 50, "wrong": 0}
"""An answer that these shots cannot tell from the truth is as good as the truth."""
FEW = {24: 1.5, 60: 1.2, 120: 1.0}
"""By what the points are multiplied that are found with so few shots."""
HINT_COST = 20
SURE = (0.5, 0.7, 0.9, 0.99)
SURE_POINTS = 25


class _Maker(Protocol):
    def __call__(self, folder: Path, *, level: int, seed: int | None, shots: int) -> None: ...


@dataclass(frozen=True, slots=True)
class Game:
    """How a challenge is played: level, counted from 1, shots, hints taken, how sure one was."""

    level: int
    shots: int
    hints: int = 0
    sure: float | None = None


@dataclass(frozen=True, slots=True)
class Score:
    """Points for what was found, with how few shots, with hints, and for being sure rightly."""

    found: int
    few: int
    hints: int
    sure: int

    @property
    def total(self) -> int:
        """All together; being sure of what is wrong may make it negative."""
        return self.found + self.few + self.hints + self.sure


def new_game(folder: Path, *, level: int, shots: int, seed: int | None = None) -> Game:
    """Make a challenge of a level, and return its game.

    Raises
    ------
    SettingsError
        There is no such level, or the folder holds something.
    StoreError
        The folder cannot be written.
    """
    module, _, name = MAKER.partition(":")
    # What a name stands for has no type before it is loaded.
    make = cast("_Maker", getattr(importlib.import_module(module), name))
    try:
        make(folder, level=level, seed=seed, shots=shots)
    except ValueError as error:
        raise SettingsError(str(error), part="level") from error
    except OSError as error:
        raise StoreError(f"the challenge cannot be written: {error}", part=str(folder)) from error
    return _keep(folder, Game(level, shots))


def game_of(folder: Path) -> Game | None:
    """Return the game of a challenge; None where it is played without one."""
    try:
        return Game(**json.loads((folder / FILE).read_text("utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def take_hint(folder: Path, game: Game) -> Game:
    """Note that a hint was taken; it costs `HINT_COST` points."""
    return _keep(folder, replace(game, hints=game.hints + 1))


def be_sure(folder: Path, game: Game, sure: float) -> Game:
    """Note how sure the answer is, a chance from 0.5 to 1."""
    return _keep(folder, replace(game, sure=sure))


def hint(folder: Path) -> str:
    """Return how much is hidden in a challenge, and nothing else of it."""
    label: Label = label_of(folder)
    if any(effect.law is not None or effect.effect not in label.answer for effect in label.effects):
        return "Something is hidden that no known effect is."
    counts = {0: "Nothing is hidden.", 1: "One effect is hidden."}
    return counts.get(len(label.effects), f"{len(label.effects)} effects are hidden.")


def score(game: Game, outcome: Outcome) -> Score:
    """Return the points of an answer.

    Sureness is scored by the square of its error, so that it pays best to state what one believes:
    0.5 gains and loses nothing.
    """
    found = FOUND[outcome]
    few = round(found * (FEW.get(game.shots, 1.0) - 1.0))
    right = 1.0 if outcome in {"right", "alias"} else 0.0
    sure = 0 if game.sure is None else round(SURE_POINTS * (1 - 4 * (game.sure - right) ** 2))
    return Score(found, few, -HINT_COST * game.hints, sure)


def _keep(folder: Path, game: Game) -> Game:
    try:
        (folder / FILE).write_text(json.dumps(asdict(game)) + "\n", encoding="utf-8")
    except OSError as error:
        raise StoreError(f"the game cannot be written: {error}", part=str(folder)) from error
    return game
