"""`rigctl model next` as it is called: a campaign folder in, shots out."""

import json
from pathlib import Path

import pytest

from rigctl.sweeps.form import read_sweep
from simulators.challenge.making import write_challenge
from tests.invoked import Invoked, rigctl

pytestmark = pytest.mark.long


def next_shots(folder: Path, *arguments: str) -> Invoked:
    return rigctl("model", "next", folder, *arguments)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("campaigns") / "nylon"
    write_challenge(path, {"restitution-viscoelastic": 0.3}, 3, 14)
    return path


def test_two_effects_are_told_apart_by_a_sweep_within_the_limits(
    folder: Path, tmp_path: Path
) -> None:
    sweep = tmp_path / "sweep.toml"
    pair = ("restitution-viscoelastic", "restitution-plastic")
    done = next_shots(folder, "--between", *pair, "--out", str(sweep), "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["between"] == list(pair)
    assert document["probability"] >= 0.9
    steps = read_sweep(sweep).steps()
    assert len(steps) == document["shots"] > 0
    assert all(5 <= step.pressure_a_kpa <= 120 and 0 <= step.offset_mm <= 24 for step in steps)


def test_a_parameter_is_sharpened_in_words(folder: Path) -> None:
    done = next_shots(folder, "--sharpen", "mu")
    assert done.returncode == 0, done.stderr
    assert "standard error of mu" in done.stdout
    assert "offset, mm" in done.stdout


def test_a_goal_that_is_reached_already_needs_no_shot(folder: Path) -> None:
    done = next_shots(folder, "--sharpen", "mu", "--to", "1", "--json")
    document = json.loads(done.stdout)
    assert document["shots"] == 0
    assert document["enough"]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("--sharpen", "nu"), 4, "e, mu, beta0"),
        (("--between", "drag", "no-such"), 4, "no-such"),
        (("--between", "drag", "drag"), 2, "twice"),
        (("--between", "drag", "timing-jitter"), 2, "noise"),
        (("--between", "drag", "none", "--sharpen", "e"), 2, "two questions"),
        (("--to", "0.1"), 2, "belongs to a parameter"),
        (("--between", "drag", "none", "--with", "drag"), 2, "of the model already"),
    ],
)
def test_a_question_that_cannot_be_answered_is_refused_in_one_sentence(
    folder: Path, arguments: tuple[str, ...], code: int, words: str
) -> None:
    done = next_shots(folder, *arguments)
    assert done.returncode == code
    assert words in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_campaign_without_settings_is_refused(folder: Path, tmp_path: Path) -> None:
    bare = tmp_path / "bare"
    bare.mkdir()
    for name in ("campaign.toml", "poses.csv"):
        (bare / name).write_bytes((folder / name).read_bytes())
    rows = (folder / "shots.csv").read_text(encoding="utf-8").splitlines()
    kept = [",".join(row.split(",")[:2]) for row in rows]
    (bare / "shots.csv").write_text("\n".join(kept) + "\n", encoding="utf-8")
    done = next_shots(bare, "--sharpen", "e")
    assert done.returncode == 2
    assert "settings" in done.stderr
