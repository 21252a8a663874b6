"""rigctl model on a campaign folder: exit codes, what is printed, and the JSON of the contract."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from analysis.quantity import Quantity
from tests.invoked import rigctl
from tests.system.test_documentation import DOCS, PYTHON, needs_shell, perform
from tests.unit.analysis.model.exchange_folder import write_campaign
from tests.unit.analysis.model.hard_spheres import campaign

COMPARE = DOCS / "how-to" / "compare-with-the-model.md"
ENDS_WITHIN_S = 220.0
STRETCH = 0.004
FIT = {
    *("campaign", "shots", "with", "chi2_per_dof", "degrees_of_freedom", "converged", "parameters"),
    *("faults", "noise", "excluded", "rejected", "rejected_frames", "torn_tracks", "alarms"),
    *("nuisances", "formulas", "rejected_why"),
}
EXPLAIN = {
    *("campaign", "shots", "used", "excluded", "rejected", "rejected_frames", "verdict", "effects"),
    *("alias_set", "alias_sets", "unexplained", "chi2_per_dof", "path", "parameters", "candidates"),
    *("noise", "structure", "next_shots", "faults", "torn_tracks", "alarms"),
    *("p_chi2", "nuisances", "formulas"),
}
pytestmark = [pytest.mark.long, pytest.mark.timeout(600)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data = campaign(20, 91)
    stretched = replace(data, position=(1 + STRETCH) * data.position)
    return write_campaign(tmp_path_factory.mktemp("campaigns") / "stretched", stretched)


def answer(*arguments: object) -> dict[str, Any]:
    """Return the one JSON document that a command prints."""
    done = rigctl("model", *arguments, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout, parse_constant=pytest.fail)


def test_fit_gives_the_law_with_standard_errors(folder: Path) -> None:
    found = answer("fit", folder, "--with", "image-scale")
    assert set(found) == FIT
    assert (found["campaign"], found["shots"], found["converged"]) == ("hard spheres", 20, True)
    assert found["with"] == ["image-scale"]
    # 24 numbers a shot, three of the law and one more; whole frames near contact are left out.
    frames, part = divmod(20 * 24 * 12 - 20 * 24 - 4 - found["degrees_of_freedom"], 12)
    assert part == 0
    assert 0 < frames <= 20
    assert found["chi2_per_dof"] == pytest.approx(1, abs=0.1)
    for name, true in {"e": 0.74, "mu": 0.08, "beta0": 0.5, "image-scale.s": STRETCH}.items():
        quantity = found["parameters"][name]
        assert set(quantity) == {"value", "sigma", "unit"}
        assert abs(quantity["value"] - true) < 4 * quantity["sigma"]


def test_rank_puts_first_what_is_missing(folder: Path) -> None:
    found = answer("rank", folder)
    assert set(found) == FIT | {"candidates"}
    assert found["chi2_per_dof"] > 1.05
    scale = next(c for c in found["candidates"] if c["effect"] == "image-scale")
    assert found["candidates"].index(scale) < 4
    assert scale["seen"]
    assert scale["p_familywise"] < 0.001
    assert scale["amplitudes"]["s"]["value"] == pytest.approx(STRETCH, rel=0.1)
    seen = [c["promised_fall"] for c in found["candidates"] if c["seen"]]
    assert seen == sorted(seen, reverse=True)


def test_rank_leaves_out_what_is_in_the_fit(folder: Path) -> None:
    found = answer("rank", folder, "--with", "image-scale")
    assert "image-scale" not in {c["effect"] for c in found["candidates"]}
    assert found["with"] == ["image-scale"]


@pytest.mark.parametrize("command", ["fit", "rank", "agreement"])
def test_a_campaign_that_is_streamed_gives_the_same_document(folder: Path, command: str) -> None:
    asked = (command, folder, "--with", "image-scale")
    assert answer(*asked, "--stream") == answer(*asked)


def test_a_streamed_verdict_is_the_same_document(folder: Path) -> None:
    assert answer("explain", folder, "--stream") == answer("explain", folder)


def test_explain_gives_the_document_that_other_programs_rely_on(folder: Path) -> None:
    found = answer("explain", folder)
    assert set(found) == EXPLAIN
    assert (found["campaign"], found["shots"], found["used"]) == ("hard spheres", 20, 20)
    assert found["verdict"] in {"effect", "alias"}
    assert "image-scale" in found["alias_set"]
    assert found["unexplained"] is False
    assert found["path"][0]["with"] == []
    assert found["path"][0]["prediction_error"] > found["path"][-1]["prediction_error"]
    assert found["path"][-1]["prediction_error"] == pytest.approx(1, abs=0.06)


def test_without_json_a_person_reads_a_table_or_a_sentence(folder: Path) -> None:
    fitted, ranked, explained = (
        rigctl("model", word, folder) for word in ("fit", "rank", "explain")
    )
    found = answer("fit", folder)
    e = Quantity(**found["parameters"]["e"])
    assert e.concise() in fitted.stdout
    assert "hard spheres: 20 shots, chi-squared per degree of freedom" in fitted.stdout
    assert "image-scale" in ranked.stdout
    assert "expected drop" in ranked.stdout
    assert explained.stdout.startswith("hard spheres: the missing effect is")
    assert "the base model" in explained.stdout


@pytest.mark.parametrize("word", ["fit", "rank", "explain"])
def test_a_folder_that_is_none_ends_with_2_and_names_the_file(word: str, tmp_path: Path) -> None:
    done = rigctl("model", word, tmp_path / "nowhere", "--json")
    assert done.returncode == 2
    assert done.stdout == ""
    assert "campaign.toml: no such file" in " ".join(done.stderr.split())


def test_a_fault_of_poses_csv_ends_with_2_and_names_its_line(tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "c", campaign(3, 92))
    path = folder / "poses.csv"
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[4] = lines[4].replace(",a,", ",c,").replace(",b,", ",c,")
    path.write_text("\n".join(lines), encoding="utf-8")
    done = rigctl("model", "explain", folder)
    assert done.returncode == 2
    assert "poses.csv, line 5" in "".join(done.stderr.split("\n"))


@pytest.mark.parametrize("word", ["fit", "rank"])
def test_an_effect_that_is_unknown_ends_with_4_and_names_those_there_are(
    word: str, folder: Path
) -> None:
    done = rigctl("model", word, folder, "--with", "aether")
    assert done.returncode == 4
    assert done.stdout == ""
    assert "'aether'" in done.stderr
    assert "image-scale" in done.stderr


@needs_shell
def test_the_guide_to_the_model_can_be_followed(tmp_path: Path) -> None:
    said = perform(COMPARE, tmp_path)
    verdict = json.loads((tmp_path / "verdict.json").read_text(encoding="utf-8"))
    assert set(verdict) == EXPLAIN
    assert "error path" in said
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", "".join(PYTHON.findall(COMPARE.read_text()))],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=ENDS_WITHIN_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    for picture in ("where-it-fails", "most-striking"):
        assert (tmp_path / "pictures" / f"{picture}.png").stat().st_size > 10_000
