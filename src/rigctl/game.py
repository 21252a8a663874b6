"""A challenge as a game: its level, what hints cost, and the score once the seal is broken."""

from __future__ import annotations

import importlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Protocol, cast

from rigctl.challenge import HiddenEffect, Label, Outcome, label_of
from rigctl.errors import RefusedError, SettingsError, StoreError

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
HINT_COSTS = (10, 20, 30)
"""Of how much is hidden, of where it acts, and of how one notices it, in the order of asking."""
HOW_MANY, WHERE, WHAT = range(len(HINT_COSTS))
COUNTED = frozenset({1, 3, 4})
"""Levels whose names say how much is hidden: no hint says it once more."""
COEFFICIENTS = ("e", "mu", "beta0")
"""Slots of laws that act at the bounce; other slots are forces between the spheres."""
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

    @property
    def offered(self) -> tuple[int, ...]:
        """The hints there are, in the order of asking, as places in `HINT_COSTS`."""
        return (WHERE, WHAT) if self.level in COUNTED else (HOW_MANY, WHERE, WHAT)

    @property
    def taken(self) -> tuple[int, ...]:
        """Those that were taken."""
        return self.offered[: self.hints]


@dataclass(frozen=True, slots=True)
class Clue:
    """Where an effect acts, such as `at the bounce`, and how one notices it, as a sentence."""

    where: str
    notice: str


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
    """Note that the next hint was taken; it costs its part of `HINT_COSTS`.

    Raises
    ------
    RefusedError
        There is no further hint.
    StoreError
        The game cannot be written.
    """
    if game.taken == game.offered:
        raise RefusedError("has given all its hints", part="the challenge")
    return _keep(folder, replace(game, hints=game.hints + 1))


def be_sure(folder: Path, game: Game, sure: float) -> Game:
    """Note how sure the answer is, a chance from 0.5 to 1."""
    return _keep(folder, replace(game, sure=sure))


def hints(folder: Path, game: Game, clues: Mapping[str, Clue]) -> list[str]:
    """Return the hints that were taken: how much is hidden, where to look, and what to look for.

    Parameters
    ----------
    clues
        Of the effects of the catalogue, by name.
    """
    label: Label = label_of(folder)
    said = _how_many(label), _where(label, clues), _what(label, clues)
    return [said[kind] for kind in game.taken]


def _how_many(label: Label) -> str:
    if any(_is_unknown(label, effect) for effect in label.effects):
        return "Something is hidden that is in no catalogue."
    counts = {0: "Nothing is hidden.", 1: "One effect is hidden."}
    return counts.get(len(label.effects), f"{len(label.effects)} effects are hidden.")


def places(folder: Path, game: Game, clues: Mapping[str, Clue]) -> list[str]:
    """Return where what is hidden acts, each place once, if the hint that says it was taken."""
    return _places(label_of(folder), clues) if WHERE in game.taken else []


def _places(label: Label, clues: Mapping[str, Clue]) -> list[str]:
    return list(
        dict.fromkeys(
            clues[effect.effect].where if effect.effect in clues else _place_of(effect.law)
            for effect in label.effects
        )
    )


def _where(label: Label, clues: Mapping[str, Clue]) -> str:
    """Say where what is hidden acts, each place once."""
    places = _places(label, clues)
    return f"Look {' and '.join(places)}." if places else "There is nowhere to look."


def _place_of(law: Sequence[str] | None) -> str:
    if law is None:
        return "at the bounce and in the air"
    return "at the bounce" if law[0] in COEFFICIENTS else "in the air, while the spheres are near"


def _what(label: Label, clues: Mapping[str, Clue]) -> str:
    """Say how what is hidden shows; of a law what it depends on."""
    said = [
        clues[effect.effect].notice
        if effect.effect in clues
        else "Something changes that no effect of the catalogue changes in this way."
        if effect.law is None
        else f"A coefficient follows this: {effect.law[1].replace('_', ' ')}."
        for effect in label.effects
    ]
    return " ".join(said) or "Every residual is noise."


def _is_unknown(label: Label, effect: HiddenEffect) -> bool:
    return effect.law is not None or effect.effect not in label.answer


def score(game: Game, outcome: Outcome) -> Score:
    """Return the points of an answer.

    Sureness is scored by the square of its error, so that stating the true chance pays best:
    0.5 gains and loses nothing.
    """
    found = FOUND[outcome]
    few = round(found * (FEW.get(game.shots, 1.0) - 1.0))
    right = 1.0 if outcome in {"right", "alias"} else 0.0
    sure = 0 if game.sure is None else round(SURE_POINTS * (1 - 4 * (game.sure - right) ** 2))
    return Score(found, few, -sum(HINT_COSTS[kind] for kind in game.taken), sure)


def _keep(folder: Path, game: Game) -> Game:
    try:
        (folder / FILE).write_text(json.dumps(asdict(game)) + "\n", encoding="utf-8")
    except OSError as error:
        raise StoreError(f"the game cannot be written: {error}", part=str(folder)) from error
    return game
