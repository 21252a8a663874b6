from __future__ import annotations

import base64
import hashlib
import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from simulators.challenge import HIDDEN, new_challenge, write_challenge
from simulators.challenge.effects import FORMED, switched
from simulators.challenge.label import draw_label, label_document
from simulators.challenge.nature import Nature


def labels(strength: str, count: int = 2000) -> list[dict[str, float]]:
    rng = np.random.default_rng(1)
    return [dict(draw_label(rng, strength)) for _ in range(count)]


def test_every_effect_is_drawn_at_full_strength() -> None:
    drawn = Counter(name for label in labels("full") for name in label)
    assert set(drawn) == set(HIDDEN)


def test_nothing_one_two_and_the_unknown_are_drawn_as_often_as_stated() -> None:
    drawn = labels("full")
    unknown = [label for label in drawn if any(not HIDDEN[name].known for name in label)]
    laws = sum(bool(set(label) & set(FORMED)) for label in drawn)
    assert laws / 2000 == pytest.approx(1 / 6, abs=0.03)
    assert sum(not label for label in drawn) / 2000 == pytest.approx(5 / 6 * 0.1, abs=0.03)
    assert len(unknown) / 2000 == pytest.approx(1 / 6 + 5 / 6 * 0.15, abs=0.03)
    assert sum(len(label) == 2 for label in drawn) / 2000 == pytest.approx(5 / 6 * 0.2, abs=0.03)
    assert {len(label) for label in unknown} == {1}


def test_two_effects_never_act_on_the_same() -> None:
    for label in labels("full"):
        assert len({HIDDEN[name].acts_on for name in label}) == len(label)


def test_a_quarter_is_a_quarter_and_leaves_out_what_no_one_could_see() -> None:
    for label in labels("quarter"):
        for name, amplitude in label.items():
            assert abs(amplitude) == HIDDEN[name].amplitude / 4
            assert not HIDDEN[name].faint


def test_signs_are_drawn_where_nature_has_both() -> None:
    signs: dict[str, set[float]] = {}
    for label in labels("full"):
        for name, amplitude in label.items():
            signs.setdefault(name, set()).add(np.sign(amplitude))
    for name, seen in signs.items():
        assert seen == ({-1.0, 1.0} if HIDDEN[name].either_sign else {1.0})


def test_every_effect_changes_nature_and_nothing_leaves_it_plain() -> None:
    assert switched({}) == Nature()
    for name, effect in HIDDEN.items():
        assert switched({name: effect.amplitude}) != Nature()


def test_a_label_answers_unexplained_for_what_no_catalogue_has() -> None:
    assert label_document({})["answer"] == ["none"]
    assert label_document({"attraction": 20.0})["answer"] == ["unexplained"]
    both = label_document({"drag": 0.45, "image-scale": -0.005})
    assert both["answer"] == ["drag", "image-scale"]
    assert [hidden["amplitude"] for hidden in both["effects"]] == [0.45, -0.005]


def test_the_seal_is_the_sha_256_of_salt_and_label(tmp_path: Path) -> None:
    write_challenge(tmp_path / "one", {"drag": 0.45}, seed=1, shots=3)
    write_challenge(tmp_path / "two", {"drag": 0.45}, seed=2, shots=3)
    public = [json.loads((tmp_path / n / "challenge.json").read_text()) for n in ("one", "two")]
    content = base64.b64decode((tmp_path / "one" / "sealed.txt").read_bytes())
    assert hashlib.sha256(content).hexdigest() == public[0]["sha256"] != public[1]["sha256"]
    assert json.loads(content[16:])["answer"] == ["drag"]


def test_no_file_of_a_challenge_names_what_it_hides_in_plain_words(tmp_path: Path) -> None:
    write_challenge(tmp_path / "x", {"attraction": 20.0}, seed=1, shots=3)
    for path in (tmp_path / "x").iterdir():
        assert "attraction" not in path.read_text()


def test_a_seed_gives_the_same_files_to_the_last_byte(tmp_path: Path) -> None:
    for parent in ("one", "two"):
        new_challenge(tmp_path / parent / "x", seed=7, shots=3)
    names = sorted(path.name for path in (tmp_path / "one" / "x").iterdir())
    assert names == ["campaign.toml", "challenge.json", "poses.csv", "sealed.txt", "shots.csv"]
    for name in names:
        assert (tmp_path / "one/x" / name).read_bytes() == (tmp_path / "two/x" / name).read_bytes()


def test_without_a_seed_two_challenges_differ(tmp_path: Path) -> None:
    for name in ("one", "two"):
        new_challenge(tmp_path / name, shots=3)
    poses = [(tmp_path / name / "poses.csv").read_text() for name in ("one", "two")]
    assert poses[0] != poses[1]


def test_a_folder_that_holds_something_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(ValueError, match="holds something already"):
        new_challenge(tmp_path, seed=1, shots=3)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize(
    ("seed", "strength", "shots", "says"),
    [(-1, "full", 9, "seed"), (1, "half", 9, "full, quarter"), (1, "full", 2, "3 to 10000")],
)
def test_what_cannot_be_is_refused_before_a_file_is_written(
    tmp_path: Path, seed: int, strength: str, shots: int, says: str
) -> None:
    with pytest.raises(ValueError, match=says):
        new_challenge(tmp_path / "x", seed=seed, strength=strength, shots=shots)
    assert not (tmp_path / "x").exists()
