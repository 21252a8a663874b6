"""`rigctl model propose`: its document, its files, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import rigctl
from rigctl.cli import run
from rigctl.sweeps.form import read_sweep
from simulators.challenge import write_challenge
from tests.invoked import rigctl as rigctl_command

SHOTS = 60
KEYS = {
    *("slot", "argument", "shape", "name", "formula", "latex", "parameters", "p_familywise"),
    *("error_before", "error_after", "alike", "alike_effects", "shapes", "within", "hint"),
    *("next_shots", "form"),
}


@pytest.fixture(scope="module")
def strange(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a campaign whose e has a bump at 5 m/s."""
    folder = tmp_path_factory.mktemp("campaigns") / "strange"
    write_challenge(folder, {"restitution-bump": 0.008}, seed=3, shots=SHOTS)
    return folder


@pytest.fixture(scope="module")
def laws(strange: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """Return the folder into which its proposal was written, and the document."""
    folder = tmp_path_factory.mktemp("laws")
    return folder, answered(str(strange), "--write", str(folder))


@pytest.fixture(scope="module")
def other(strange: Path) -> Path:
    """Return another campaign with the same bump."""
    folder = strange.with_name("other")
    write_challenge(folder, {"restitution-bump": 0.008}, seed=5, shots=SHOTS)
    return folder


@pytest.fixture(scope="module")
def together(strange: Path, other: Path) -> dict[str, Any]:
    """Return what both are said to share, as this process finds it."""
    return answered(str(strange), "--together", str(other))


def answered(*words: str) -> dict[str, Any]:
    done = rigctl_command("model", "propose", *words, "--json")
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_the_document_has_the_keys_of_the_contract(laws: tuple[Path, dict[str, Any]]) -> None:
    _, found = laws
    assert (found["campaign"], found["shots"], found["verdict"]) == ("strange", SHOTS, "proposal")
    [one] = found["proposals"]
    assert set(one) == KEYS
    assert (one["slot"], one["argument"], one["shape"]) == ("e", "speed_n", "bump")
    assert set(one["parameters"]) == {"a", "m", "w"}
    assert one["parameters"]["m"]["unit"] == "m/s"
    assert one["error_after"] < one["error_before"]


def test_the_files_are_an_effect_that_can_be_fitted_and_a_sweep(
    strange: Path, laws: tuple[Path, dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    folder, _ = laws
    assert {path.name for path in folder.iterdir()} == {
        "proposed_e_speed_n_bump.py",
        "next_shots.toml",
    }
    name = "proposed-e-speed-n-bump"
    capsys.readouterr()
    words = ["model", "fit", str(strange), "--with", name, "--effects", str(folder), "--json"]
    assert run(words) == 0
    amplitude = json.loads(capsys.readouterr().out)["parameters"][f"{name}.a"]
    assert abs(amplitude["value"] - 0.008) < 5 * amplitude["sigma"]
    assert len(read_sweep(folder / "next_shots.toml").shots) > 1


def test_a_form_is_confirmed_on_another_campaign_and_refused_on_its_own_shots(
    strange: Path,
    laws: tuple[Path, dict[str, Any]],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    file = str(laws[0] / "proposed_e_speed_n_bump.py")
    write_challenge(tmp_path / "again", {"restitution-bump": 0.008}, seed=4, shots=SHOTS)
    found = answered(str(tmp_path / "again"), "--confirm", file)
    assert (found["confirmed"], found["used"]) == (True, SHOTS)
    assert run(["model", "propose", str(strange), "--confirm", file]) == 2
    assert "0 shots of these did not take part" in capsys.readouterr().err


def warm(folder: Path, seed: int, per_kelvin: float) -> Path:
    """Write a campaign whose pushers gain speed with the temperature: v^2 goes as the pressure."""
    write_challenge(folder, {}, seed=seed, shots=SHOTS)
    head, *rows = (folder / "shots.csv").read_text().splitlines()
    names = head.split(",")
    changed = []
    for row in rows:
        values = dict(zip(names, row.split(","), strict=True))
        gain = 1.0 + per_kelvin * (float(values["temperature_c"]) - 23.0)
        for name in ("pressure_a_kpa", "pressure_b_kpa"):
            values[name] = f"{float(values[name]) / gain**2:.4f}"
        changed.append(",".join(values.values()))
    (folder / "shots.csv").write_text("\n".join([head, *changed]) + "\n")
    return folder


def test_a_law_of_the_launch_is_written_and_confirmed_on_the_launches_that_follow(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first, second = warm(tmp_path / "first", 3, 0.01), warm(tmp_path / "second", 8, 0.01)
    laws = tmp_path / "laws"
    found = answered(str(first), "--write", str(laws))
    [one] = found["proposals"]
    assert (one["slot"], one["argument"]) == ("launch", "temperature_c")
    [file] = found["files"]
    assert one["form"]["shots"] == f"1-{SHOTS}"
    tested = answered(str(second), "--confirm", file)
    assert (tested["confirmed"], tested["p_value"] < 1e-6) == (True, True)
    plain = answered(str(warm(tmp_path / "plain", 9, 0.0)), "--confirm", file)
    assert plain["p_value"] > 1e-4
    assert run(["model", "propose", str(first), "--confirm", file]) == 2
    assert "0 shots of these did not take part" in capsys.readouterr().err


def test_a_file_that_states_no_form_is_refused(
    strange: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "law.json"
    for text, why in (("{", "cannot be read"), ("{}", "no object of the name form")):
        path.write_text(text)
        assert run(["model", "propose", str(strange), "--confirm", str(path)]) == 2
        assert why in capsys.readouterr().err


@pytest.mark.long
def test_several_campaigns_are_asked_at_once(
    strange: Path, other: Path, together: dict[str, Any]
) -> None:
    assert together["campaigns"] == ["strange", "other"]
    first = together["shared"][0]
    assert (first["slot"], first["argument"]) == ("e", "speed_n")
    assert [own["campaign"] for own in first["each"]] == ["strange", "other"]
    assert rigctl.open(strange).propose_together(rigctl.open(other)) == together


@pytest.mark.long
def test_processes_read_and_ask_their_own_campaigns_with_the_same_answer(
    strange: Path, other: Path, together: dict[str, Any]
) -> None:
    there = answered(str(strange), "--together", str(other), "--workers", "1")
    assert there["campaigns"] == ["strange", "other"]
    assert [(one["slot"], one["argument"]) for one in there["shared"]] == [
        (one["slot"], one["argument"]) for one in together["shared"]
    ]
    first, second = together["shared"][0]["amplitude"], there["shared"][0]["amplitude"]
    assert second == pytest.approx(first, rel=1e-6)


def test_columns_of_words_with_gaps_that_never_change_or_copy_are_named_with_what_to_do(
    tmp_path: Path,
) -> None:
    write_challenge(tmp_path / "odd", {}, seed=1, shots=24)
    path = tmp_path / "odd" / "shots.csv"
    head, *rows = path.read_text().splitlines()
    warm = head.split(",").index("temperature_c")
    more = [
        f"{row},{'soft' if k % 2 else 'hard'},{'' if k == 3 else k},31.5,"
        f"{float(row.split(',')[warm]) + 273.15:.2f}"
        for k, row in enumerate(rows)
    ]
    path.write_text("\n".join([f"{head},paper,humidity_pct,lamp_c,room_k", *more]) + "\n")
    said = {one["argument"]: one for one in answered(str(tmp_path / "odd"))["left_out"]}
    assert said["paper"]["reason"] == "holds words"
    assert said["humidity_pct"]["reason"] == "empty in some shots"
    assert said["lamp_c"]["reason"] == "the same in all shots, 31.5"
    copy = said.get("room_k") or said["temperature_c"]
    assert "one and the same as" in copy["reason"]
    assert all(one["todo"] for one in said.values())


def test_five_shots_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_challenge(tmp_path / "few", {}, seed=1, shots=5)
    assert run(["model", "propose", str(tmp_path / "few")]) == 2
    assert "at least 12 are needed" in capsys.readouterr().err


def test_an_effect_that_is_not_there_is_not_found(strange: Path) -> None:
    assert run(["model", "propose", str(strange), "--with", "phlogiston"]) == 4
