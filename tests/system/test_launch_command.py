"""rigctl model launch on campaign folders: what it prints, and how it ends."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from simulators.challenge.making import write_challenge
from tests.invoked import rigctl

pytestmark = pytest.mark.long

SHOTS = 40


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a campaign that hides nothing, of pushers with friction."""
    folder = tmp_path_factory.mktemp("campaigns") / "plain"
    write_challenge(folder, {}, seed=5, shots=SHOTS)
    return folder


def answer(*arguments: object) -> dict[str, Any]:
    done = rigctl("model", "launch", *arguments, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout, parse_constant=pytest.fail)


def copied(folder: Path, to: Path, change: dict[str, str]) -> Path:
    shutil.copytree(folder, to)
    text = (to / "shots.csv").read_text(encoding="utf-8")
    for old, new in change.items():
        assert old in text
        text = text.replace(old, new)
    (to / "shots.csv").write_text(text, encoding="utf-8")
    return to


def test_the_document_holds_parameters_quantities_and_candidates(folder: Path) -> None:
    found = answer(folder)
    assert set(found) == {
        *("campaign", "shots", "rejected", "with", "converged"),
        *("parameters", "quantities", "candidates"),
    }
    assert (found["campaign"], found["shots"], found["converged"]) == ("plain", SHOTS, True)
    assert found["with"] == ["pressure-friction"]
    friction = found["parameters"]["pressure-friction.p_a"]
    assert friction["unit"] == "kPa"
    assert abs(friction["value"] - 5.762) < 4 * friction["sigma"]
    speed = next(row for row in found["quantities"] if row["quantity"] == "speed")
    assert (speed["unit"], speed["count"]) == ("m/s", 2 * SHOTS)
    assert 0 < 0.9 * speed["scatter"] < speed["prediction_rms"] < 0.1
    assert min(c["p_familywise"] for c in found["candidates"] if not c["fitted"]) > 0.01
    assert len(found["candidates"]) == 6


def test_an_effect_may_be_added_and_friction_named_again(folder: Path) -> None:
    found = answer(folder, "--with", "tube-spin", "--with", "pressure-friction")
    assert found["with"] == ["pressure-friction", "tube-spin"]
    spin = found["parameters"]["tube-spin.c"]
    assert abs(spin["value"]) < 4 * spin["sigma"]


def test_a_person_reads_three_tables(folder: Path) -> None:
    done = rigctl("model", "launch", folder)
    assert done.returncode == 0, done.stderr
    assert f"plain: launches of {SHOTS} shots" in done.stdout
    for words in ("pushers and tubes", "foretold from the settings", "effects", "in the fit"):
        assert words in done.stdout


def test_an_effect_that_is_none_of_the_launch_ends_with_4_and_the_names(folder: Path) -> None:
    done = rigctl("model", "launch", folder, "--with", "drag")
    assert done.returncode == 4
    assert "slide-backlash" in done.stderr


def test_a_campaign_without_offsets_ends_with_2_and_the_shot(folder: Path, tmp_path: Path) -> None:
    bare = copied(folder, tmp_path / "bare", {"offset_mm": "note"})
    done = rigctl("model", "launch", bare)
    assert done.returncode == 2
    assert "shot 1 has no offset_mm" in done.stderr


def test_a_pressure_of_nothing_ends_with_2_and_what_was_found(folder: Path, tmp_path: Path) -> None:
    campaign = copied(folder, tmp_path / "campaign", {})
    rows = (campaign / "shots.csv").read_text(encoding="utf-8").splitlines()
    number, time, _, rest = rows[1].split(",", 3)
    rows[1] = f"{number},{time},0,{rest}"
    (campaign / "shots.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    done = rigctl("model", "launch", campaign)
    assert done.returncode == 2
    assert "a pressure of 0 kPa" in done.stderr
