from __future__ import annotations

import json
from pathlib import Path

import pytest

from rigctl import cli
from rigctl.challenge import HiddenEffect, Label, judge, summary
from simulators.challenge import write_challenge


@pytest.fixture
def challenge(tmp_path: Path) -> Path:
    """Return the folder of a challenge that hides drag."""
    write_challenge(tmp_path / "x", {"drag": 0.45}, seed=1, shots=3)
    return tmp_path / "x"


def answered(folder: Path, answer: str) -> int:
    return cli.run(["challenge", "commit", str(folder), "--answer", answer])


def revealed(folder: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    capsys.readouterr()
    assert cli.run(["challenge", "reveal", str(folder), "--json"]) == 0
    found: dict[str, object] = json.loads(capsys.readouterr().out)
    return found


def test_a_challenge_is_made_answered_and_revealed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "x"
    assert cli.run(["challenge", "new", str(folder), "--seed", "4", "--shots", "5"]) == 0
    assert len((folder / "shots.csv").read_text().splitlines()) == 6
    assert answered(folder, "drag, image-scale") == 0
    found = revealed(folder, capsys)
    assert found["answer"] == ["drag", "image-scale"]
    assert found["outcome"] in {"right", "alias", "partly", "wrong"}
    assert found["truth"]


def test_the_truth_comes_with_its_amplitude(
    challenge: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert answered(challenge, "drag") == 0
    found = revealed(challenge, capsys)
    assert (found["outcome"], found["truth"]) == ("right", ["drag"])
    assert found["effects"] == [
        {"effect": "drag", "amplitude": 0.45, "unit": "1", "meaning": "drag coefficient"}
    ]
    assert cli.run(["challenge", "reveal", str(challenge)]) == 0
    assert "right: answered drag; the truth is drag" in capsys.readouterr().out


def test_nothing_is_revealed_before_an_answer(
    challenge: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["challenge", "reveal", str(challenge)]) == 3
    shown = capsys.readouterr()
    assert "commit first" in shown.err
    assert "drag" not in shown.out + shown.err


def test_an_answer_is_never_changed(challenge: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert answered(challenge, "wind") == 0
    before = (challenge / "answer.json").read_bytes()
    assert answered(challenge, "drag") == 3
    assert "never changed" in capsys.readouterr().err
    assert (challenge / "answer.json").read_bytes() == before
    assert [path.name for path in challenge.glob("answer*")] == ["answer.json"]


def test_a_label_put_in_afterwards_is_noticed(
    challenge: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_challenge(tmp_path / "other", {"wind": 2.0}, seed=1, shots=3)
    assert answered(challenge, "wind") == 0
    (challenge / "sealed.txt").write_bytes((tmp_path / "other/sealed.txt").read_bytes())
    assert cli.run(["challenge", "reveal", str(challenge)]) == 3
    assert "not the one that was sealed" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["challenge.json", "sealed.txt", "answer.json"])
def test_a_damaged_file_is_named(
    challenge: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert answered(challenge, "drag") == 0
    (challenge / name).write_bytes(b"{not this")
    assert cli.run(["challenge", "reveal", str(challenge)]) == 2
    assert name in capsys.readouterr().err


@pytest.mark.parametrize(
    ("answer", "code"),
    [("dragg", 4), ("", 4), ("drag,drag", 2), ("none,drag", 2), ("drag,unexplained", 2)],
)
def test_an_answer_that_makes_no_sense_is_not_written(
    challenge: Path, answer: str, code: int
) -> None:
    assert answered(challenge, answer) == code
    assert not (challenge / "answer.json").exists()


@pytest.mark.parametrize("answer", ["none", "unexplained", "adhesion", "drag,mirror-angle"])
def test_an_answer_may_name_whatever_catalogue_or_challenge_holds(
    challenge: Path, answer: str
) -> None:
    assert answered(challenge, answer) == 0


@pytest.mark.parametrize("command", [["commit", "--answer", "none"], ["reveal"]])
def test_a_folder_that_is_no_challenge_is_not_found(tmp_path: Path, command: list[str]) -> None:
    assert cli.run(["challenge", *command, str(tmp_path)]) == 4


def test_a_folder_in_use_is_bad_input(challenge: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["challenge", "new", str(challenge)]) == 2
    assert "holds something already" in capsys.readouterr().err


def label(
    *truth: str, beside: tuple[str, ...] = (), world: tuple[str, ...] = (), **like: list[str]
) -> Label:
    hidden = [HiddenEffect(effect=name, amplitude=1.0, unit="1", meaning="") for name in truth]
    near = {name.replace("_", "-"): names for name, names in like.items()}
    own = list(world)
    return Label(answer=list(truth), effects=hidden, like=near, beside=list(beside), world=own)


ALWAYS = ("lasting-contact",)
PAIR = label("drag", "pixel-aspect", drag=["wind"])

JUDGED = [
    (label("none"), ["none"], "right"),
    (label("none"), ["drag"], "wrong"),
    (label("unexplained"), ["unexplained"], "right"),
    (label("drag"), ["none"], "wrong"),
    (label("drag", drag=["wind"]), ["wind"], "alias"),
    (label("drag", drag=["wind"]), ["wind", "drag"], "partly"),
    (label("wind", beside=("drag",)), ["drag", "wind"], "right"),
    (label("drag", world=ALWAYS), ["drag", "lasting-contact"], "right"),
    (label("drag", world=ALWAYS), ["drag"], "right"),
    (label("drag", world=ALWAYS), ["lasting-contact"], "wrong"),
    (label("none", world=ALWAYS), ["lasting-contact"], "right"),
    (PAIR, ["pixel-aspect", "drag"], "right"),
    (PAIR, ["pixel-aspect", "wind"], "alias"),
    (PAIR, ["pixel-aspect"], "partly"),
    (PAIR, ["pixel-aspect", "image-scale"], "partly"),
    (PAIR, ["image-scale", "mirror-angle"], "wrong"),
]


def test_a_reveal_says_what_the_world_has_whatever_it_hides() -> None:
    truth = label("drag", world=ALWAYS)
    said = summary(truth, ["drag", *ALWAYS], "right", as_json=False)
    assert "the truth is drag, on top of lasting-contact, which this world always has" in said
    assert "on top of" not in summary(label("drag"), ["drag"], "right", as_json=False)


@pytest.mark.parametrize(("truth", "answer", "outcome"), JUDGED)
def test_answers_are_judged(truth: Label, answer: list[str], outcome: str) -> None:
    assert judge(truth, answer) == outcome


LAW = ["--law", "e", "temperature_c", "power"]


def test_a_law_is_compared_with_the_true_one_slot_argument_and_shape(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "y"
    write_challenge(folder, {"restitution-temperature": 0.008}, seed=1, shots=3)
    words = ["challenge", "commit", str(folder), "--answer", "unexplained"]
    assert cli.run([*words, *LAW]) == 0
    found = revealed(folder, capsys)
    assert found["outcome"] == "right"
    assert found["law"] == {
        "answer": ["e", "temperature_c", "power"],
        "truth": ["e", "temperature_c", "linear"],
        "right": {"slot": True, "argument": True, "shape": False},
    }
    assert cli.run(["challenge", "reveal", str(folder)]) == 0
    said = capsys.readouterr().out
    assert "its law: e against temperature_c, linear" in said
    assert "right: slot, argument" in said


def test_a_law_where_the_catalogue_has_the_answer_is_wrong_in_all_of_it(
    challenge: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert answered(challenge, "unexplained") == 0
    (challenge / "answer.json").write_text(
        json.dumps({"answer": ["unexplained"], "law": LAW[1:]}), encoding="utf-8"
    )
    found = revealed(challenge, capsys)
    assert found["law"] == {
        "answer": LAW[1:],
        "truth": None,
        "right": {"slot": False, "argument": False, "shape": False},
    }


def test_a_law_beside_a_named_effect_is_refused(challenge: Path) -> None:
    words = ["challenge", "commit", str(challenge), "--answer", "drag"]
    assert cli.run([*words, *LAW]) == 2
    assert not (challenge / "answer.json").exists()


@pytest.mark.parametrize(
    ("law", "word"),
    [
        (("eps", "speed_n", "bump"), "no slot of a law has this name"),
        (("e", "speedn", "bump"), "no argument of a law has this name"),
        (("e", "speed_n*lamp_c", "linear"), "no argument of a law has this name"),
        (("e", "shot", "linear"), "no argument of a law has this name"),
        (("e", "note", "linear"), "no argument of a law has this name"),
        (("e", "speed_n*shot", "linear"), "no argument of a law has this name"),
        (("e", "speed_n", "bumpy"), "no shape of a law has this name"),
    ],
)
def test_a_law_of_unknown_words_is_refused_before_the_answer_stands(
    challenge: Path, capsys: pytest.CaptureFixture[str], law: tuple[str, ...], word: str
) -> None:
    shots = challenge / "shots.csv"
    first, *rows = shots.read_text(encoding="utf-8").splitlines()
    noted = [f"{first},note", *(f"{row},as planned" for row in rows)]
    shots.write_text("\n".join(noted) + "\n", encoding="utf-8")
    words = ["challenge", "commit", str(challenge), "--answer", "unexplained", "--law", *law]
    assert cli.run(words) == 2
    assert word in capsys.readouterr().err
    assert not (challenge / "answer.json").exists()


@pytest.mark.parametrize(
    "content", [b"shot,temp\xe9rature_c\n1,20\n", b'shot,"temperature_c\n1,20\n']
)
def test_a_law_beside_a_shot_list_that_cannot_be_read_is_refused_in_a_sentence(
    challenge: Path, capsys: pytest.CaptureFixture[str], content: bytes
) -> None:
    (challenge / "shots.csv").write_bytes(content)
    words = ["challenge", "commit", str(challenge), "--answer", "unexplained", *LAW]
    assert cli.run(words) in range(2, 10)
    said = capsys.readouterr().err
    assert "shots.csv" in said
    assert "Traceback" not in said
    assert not (challenge / "answer.json").exists()


def test_the_arguments_of_a_product_may_stand_in_any_order(challenge: Path) -> None:
    words = ["challenge", "commit", str(challenge), "--answer", "unexplained"]
    assert cli.run([*words, "--law", "e", "temperature_c*speed_n", "linear"]) == 0
    stated = json.loads((challenge / "answer.json").read_text(encoding="utf-8"))["law"]
    assert stated == ["e", "speed_n*temperature_c", "linear"]
