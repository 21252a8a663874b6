"""rigctl model agreement, and the pictures of agreement, rank and explain."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import pytest

from tests.invoked import rigctl
from tests.unit.analysis.model.exchange_folder import write_campaign
from tests.unit.analysis.model.hard_spheres import Hidden, campaign

STAGES = ["before contact", "after contact", "flight", "camera"]
PICTURES = {
    "agreement": {
        *("agreement", "structure", "rebound"),
        *(f"residuals-{place}" for place in (1, 2, 3, 4)),
    },
    "rank": {"ranking", "aliases"},
    "explain": {"error-path", "ranking", "aliases", "structure", "rebound"},
}
pytestmark = [pytest.mark.long, pytest.mark.timeout(600)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data = campaign(20, 95, hidden=Hidden(slope=0.05))
    data = replace(data, shots=data.shots + 6)
    return write_campaign(tmp_path_factory.mktemp("campaigns") / "soft", data)


def test_agreement_says_where_the_model_fails_and_hands_over_what_a_page_draws(
    folder: Path,
) -> None:
    done = rigctl("model", "agreement", folder, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout, parse_constant=pytest.fail)
    assert [stage["stage"] for stage in found["stages"]] == STAGES
    assert "the launch is left out" in done.stderr
    rows = {row["quantity"]: row for row in found["stages"][1]["quantities"]}
    assert rows["normal velocity"]["p_familywise"] < 0.01
    assert rows["normal velocity"]["unit"] == "mm/s"
    assert rows["normal velocity"]["size"] > rows["normal velocity"]["floor"]
    assert found["prediction_error"] > 1
    assert found["noise"]["positions"]["value"] == pytest.approx(1, abs=0.05)
    first, drawn = found["structure"]["cells"][0], found["structure"]["residuals"][0]
    assert first["channel"] == drawn["channel"] == "relative velocity n"
    assert drawn["shots"] == list(range(7, 27))
    assert len(drawn["x"]) == len(drawn["residual"]) == len(drawn["sigma"]) == 20
    assert len(drawn["trend"]["x"]) == len(drawn["trend"]["mean"])
    assert len(found["plane"]["x"]) == 20


def test_agreement_improves_with_the_effect_that_is_missing(folder: Path) -> None:
    done = rigctl("model", "agreement", folder, "--with", "restitution-viscoelastic", "--json")
    found = json.loads(done.stdout)
    assert found["with"] == ["restitution-viscoelastic"]
    p_values = [row["p_familywise"] for s in found["stages"] for row in s["quantities"]]
    assert min(p_values) > 0.01


def test_without_json_a_person_reads_the_table(folder: Path) -> None:
    done = rigctl("model", "agreement", folder)
    assert done.returncode == 0, done.stderr
    for words in ("before contact", "normal velocity", "mm/s", "structure that is left"):
        assert words in done.stdout


@pytest.mark.parametrize("word", list(PICTURES))
def test_pictures_are_written_beside_what_is_printed(
    word: str, folder: Path, tmp_path: Path
) -> None:
    done = rigctl("model", word, folder, "--json", "--out", tmp_path / "pictures")
    assert done.returncode == 0, done.stderr
    json.loads(done.stdout)
    written = sorted((tmp_path / "pictures").iterdir())
    assert {path.stem for path in written} == PICTURES[word]
    assert {path.suffix for path in written} == {".png", ".svg"}
    assert all(cv2.imread(str(p)) is not None for p in written if p.suffix == ".png")


def test_pictures_that_cannot_be_written_end_with_3_and_name_the_place(
    folder: Path, tmp_path: Path
) -> None:
    (tmp_path / "taken").write_text("a file")
    done = rigctl("model", "rank", folder, "--json", "--out", tmp_path / "taken")
    assert done.returncode == 3
    assert json.loads(done.stdout)["candidates"]
    assert "a picture cannot be written" in done.stderr
    assert "--out" in done.stderr
