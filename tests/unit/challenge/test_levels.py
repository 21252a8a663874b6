"""Levels of the game: each hides what it says, and the score pays for honesty."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import rigctl
from rigctl.challenge import label_of
from rigctl.errors import RefusedError, SettingsError
from rigctl.game import Clue, Game, be_sure, game_of, hints, new_game, places, score, take_hint
from simulators.challenge.effects import HIDDEN, Hidden
from simulators.challenge.making import write_challenge

SEEDS = range(4)


def first_level(effect: Hidden) -> bool:
    return effect.known and not effect.like and not effect.subtle


@pytest.mark.parametrize(("level", "counts"), [(1, {1}), (2, {0, 1}), (3, {2}), (4, {1})])
def test_a_level_hides_as_many_known_effects_as_it_says(
    tmp_path: Path, level: int, counts: set[int]
) -> None:
    for seed in SEEDS:
        folder = tmp_path / f"{seed}"
        new_game(folder, level=level, shots=3, seed=seed)
        label = label_of(folder)
        assert len(label.effects) in counts
        assert "unexplained" not in label.answer
        if level == 1:
            assert label.like == {}
        if level == 4:
            assert label.like != {}


@pytest.mark.long
@pytest.mark.parametrize("name", [one.name for one in HIDDEN.values() if first_level(one)])
def test_what_the_first_level_hides_shows_plainly_in_120_shots(tmp_path: Path, name: str) -> None:
    effect = HIDDEN[name]
    write_challenge(tmp_path / "made", {name: effect.amplitude}, 5, 120)
    assert rigctl.open(tmp_path / "made").fit().chi2_per_dof > 1.06


def test_a_game_is_kept_beside_its_challenge_and_says_nothing_of_the_truth(tmp_path: Path) -> None:
    folder = tmp_path / "made"
    played = new_game(folder, level=1, shots=24, seed=1)
    assert game_of(folder) == played == Game(1, 24)
    hidden = label_of(folder).effects[0].effect
    assert hidden not in (folder / "game.json").read_text()
    played = be_sure(folder, take_hint(folder, played), 0.9)
    assert game_of(folder) == played == Game(1, 24, hints=1, sure=0.9)


def test_the_first_hint_says_how_much_is_hidden_where_the_level_does_not(tmp_path: Path) -> None:
    said = ("Nothing is hidden.", "One effect is hidden.")
    for seed in SEEDS:
        folder = tmp_path / str(seed)
        played = new_game(folder, level=2, shots=3, seed=seed)
        count = len(label_of(folder).effects)
        assert hints(folder, take_hint(folder, played), {}) == [said[count]]


@pytest.mark.parametrize("level", [1, 3, 4])
def test_where_the_level_says_how_much_the_first_hint_says_where(
    tmp_path: Path, level: int
) -> None:
    played = new_game(tmp_path / "made", level=level, shots=3, seed=2)
    played = take_hint(tmp_path / "made", played)
    assert hints(tmp_path / "made", played, {})[0].startswith("Look ")
    assert score(played, "right").hints == -20


def test_further_hints_say_where_to_look_and_what_for_and_name_no_effect(tmp_path: Path) -> None:
    new_game(tmp_path / "made", level=1, shots=3, seed=2)
    hidden = label_of(tmp_path / "made").effects[0].effect
    clues = {hidden: Clue("in the air", "Both spheres slow down.")}
    where, notice = hints(tmp_path / "made", Game(1, 3, hints=2), clues)
    assert where == "Look in the air."
    assert notice == "Both spheres slow down."


def test_the_place_is_shown_once_the_hint_that_names_it_was_taken(tmp_path: Path) -> None:
    new_game(tmp_path / "made", level=1, shots=3, seed=2)
    hidden = label_of(tmp_path / "made").effects[0].effect
    clues = {hidden: Clue("in the air", "Both spheres slow down.")}
    games = [Game(level, 3, hints=taken) for level in (1, 2) for taken in range(3)]
    shown = [places(tmp_path / "made", played, clues) for played in games]
    assert shown == [[], ["in the air"], ["in the air"], [], [], ["in the air"]]


def test_there_are_three_hints_and_no_fourth(tmp_path: Path) -> None:
    played = new_game(tmp_path / "made", level=2, shots=3, seed=2)
    for _ in range(3):
        played = take_hint(tmp_path / "made", played)
    with pytest.raises(RefusedError, match="all its hints"):
        take_hint(tmp_path / "made", played)
    assert score(played, "right").hints == -60


def test_there_is_no_level_nought_and_no_seventh(tmp_path: Path) -> None:
    for level in (0, 7):
        with pytest.raises(SettingsError, match="levels are 1 to 6"):
            new_game(tmp_path / "none", level=level, shots=3)


def test_a_damaged_game_is_none(tmp_path: Path) -> None:
    (tmp_path / "game.json").write_text(json.dumps({"level": 1, "cheat": True}))
    assert game_of(tmp_path) is None


def test_few_shots_and_no_hints_give_more() -> None:
    assert score(Game(1, 24), "right").total == 150
    assert score(Game(1, 120), "alias").total == 100
    assert score(Game(2, 120, hints=2), "partly").total == 20
    assert score(Game(1, 24), "wrong").total == 0


@pytest.mark.parametrize("believed", [0.5, 0.7, 0.9, 0.99])
def test_it_pays_best_to_say_how_sure_one_is(believed: float) -> None:
    def expected(said: float) -> float:
        right = score(Game(1, 120, sure=said), "right").sure
        wrong = score(Game(1, 120, sure=said), "wrong").sure
        return believed * right + (1 - believed) * wrong

    assert max((0.5, 0.7, 0.9, 0.99), key=expected) == believed
    assert score(Game(1, 120, sure=0.5), "wrong").sure == 0
