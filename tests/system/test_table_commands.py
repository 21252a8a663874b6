"""rigctl model on tables of contacts: documents as of poses, and what a table cannot say."""

from __future__ import annotations

from pathlib import Path

import pytest

from simulators.challenge.drops import Drop
from tests.invoked import rigctl
from tests.system.test_model_commands import EXPLAIN, FIT, answer
from tests.unit.analysis.model.dropped import write_drops
from tests.unit.analysis.model.tabulated import PLATE, contacts, impacts

pytestmark = [pytest.mark.long, pytest.mark.timeout(600)]


@pytest.fixture(scope="module")
def plate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return impacts(tmp_path_factory.mktemp("tables") / "plate", 20, 61, description=PLATE)


@pytest.fixture(scope="module")
def spheres(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return contacts(tmp_path_factory.mktemp("tables") / "spheres", 20, 62)


def test_fit_of_a_table_gives_the_law(plate: Path) -> None:
    found = answer("fit", plate)
    assert set(found) >= FIT
    assert found["degrees_of_freedom"] == 20 * 2 - 3
    assert found["parameters"]["e"]["value"] == pytest.approx(0.74, abs=0.01)


def test_rank_says_of_every_effect_whether_the_table_shows_it(spheres: Path) -> None:
    candidates = {c["effect"]: c["seen"] for c in answer("rank", spheres)["candidates"]}
    assert candidates["restitution-viscoelastic"]
    assert not candidates["drag"]
    assert not candidates["timing-jitter"]


def test_agreement_and_verdict_of_a_table_are_documents_of_the_same_form(spheres: Path) -> None:
    stages = answer("agreement", spheres)["stages"]
    assert [stage["stage"] for stage in stages] == ["after contact"]
    verdict = answer("explain", spheres)
    assert set(verdict) >= EXPLAIN
    assert (verdict["verdict"], verdict["used"]) == ("none", 20)


def test_an_effect_that_a_table_cannot_show_is_not_fitted(plate: Path) -> None:
    done = rigctl("model", "fit", plate, "--with", "drag")
    assert (done.returncode, done.stdout) == (2, "")
    assert "cannot be seen in tabulated contacts (found 'drag')" in done.stderr


def test_errors_that_are_not_stated_are_spoken_of(tmp_path: Path) -> None:
    written = impacts(tmp_path, 12, 63, sigma=None)
    for word in ("fit", "explain"):
        done = rigctl("model", word, written)
        assert done.returncode == 0, done.stderr
        assert "no errors are stated" in " ".join(done.stderr.split())


def test_a_fault_in_a_table_ends_with_2_and_is_named(tmp_path: Path) -> None:
    written = impacts(tmp_path, 3, 64)
    path = written / "impacts.csv"
    path.write_text(path.read_text(encoding="utf-8").replace("\n2,-", "\n2,"), encoding="utf-8")
    done = rigctl("model", "fit", written)
    assert done.returncode == 2
    assert "impacts.csv, line 3: v_n: " in " ".join(done.stderr.split())


def test_poses_of_a_dropped_ball_go_through_every_command(tmp_path: Path) -> None:
    ball = Drop(drag_coefficient=0.45, viscous=True)
    flight = {"rate_hz": 250.0, "lasts_s": 0.8, "sigma_m": 4e-5}
    throw = {"heights_m": (0.03, 0.6), "sideways": 0.02, "spinning": 1.0}
    drops = write_drops(tmp_path / "d", ball, shots=12, seed=4, markers=False, **flight, **throw)
    fit = answer("fit", drops)
    assert fit["parameters"]["e"]["value"] == pytest.approx(0.73, abs=0.05)
    candidates = {c["effect"]: c["seen"] for c in answer("rank", drops)["candidates"]}
    assert candidates["restitution-viscoelastic"]
    assert candidates["wind"]
    assert not {"mass-mismatch", "radius-mismatch"} & set(candidates)
    stages = [stage["stage"] for stage in answer("agreement", drops)["stages"]]
    assert {"before contact", "after contact", "flight"} <= set(stages)
    verdict = answer("explain", drops)
    assert set(verdict) >= EXPLAIN
    assert "restitution-viscoelastic" in verdict["effects"]
