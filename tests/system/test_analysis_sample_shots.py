"""The sample shots beside a development checkout, made by a renderer that is not the project's."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.campaign import analyse_campaign, read_campaign
from analysis.shot import AnalysisOptions, MeasuredShot
from rigctl import cli
from tests.invoked import rigctl

SAMPLES = Path(__file__).resolve().parents[3] / "shared" / "data" / "sample-shots"

pytestmark = [
    pytest.mark.shared_data,
    pytest.mark.skipif(not SAMPLES.is_dir(), reason="the sample shots are not beside this tree"),
]

Truth = dict[str, Any]


@pytest.fixture(scope="module")
def truths() -> dict[int, Truth]:
    shots = json.loads((SAMPLES / "truth.json").read_text(encoding="utf-8"))["shots"]
    return {shot["shot"]: shot for shot in shots}


@pytest.fixture(scope="module")
def measured() -> dict[int, MeasuredShot]:
    done = analyse_campaign(read_campaign(SAMPLES), AnalysisOptions(), workers=1)
    return {job.shot: shot for job, shot, _ in done if isinstance(shot, MeasuredShot)}


def rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.long
def test_at_least_seven_of_eight_are_measured(measured: dict[int, MeasuredShot]) -> None:
    assert len(measured) >= 7


@pytest.mark.long
def test_normal_velocity_and_restitution_are_right_within_a_per_cent(
    measured: dict[int, MeasuredShot], truths: dict[int, Truth]
) -> None:
    shares, restitutions = [], []
    for number, shot in measured.items():
        truth = truths[number]
        shares.append(shot.impact.v_n.value / truth["v_n"] - 1.0)
        restitutions.append(shot.impact.e.value + truth["v_n_after"] / truth["v_n"])
    assert rms(shares) < 0.01
    assert rms(restitutions) < 0.01


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "key", "limit"),
    [
        ("v_s", "v_s", 0.08),
        ("v_s_after", "v_s_after", 0.08),
        ("contact_time", "contact_time_s", 1e-4),
    ],
)
def test_surface_velocities_and_contact_times_are_right_within_their_bounds(
    measured: dict[int, MeasuredShot], truths: dict[int, Truth], name: str, key: str, limit: float
) -> None:
    errors = [getattr(s.impact, name).value - truths[n][key] for n, s in measured.items()]
    assert rms(errors) < limit


@pytest.mark.long
def test_no_marker_is_mixed_up_with_another(
    measured: dict[int, MeasuredShot], truths: dict[int, Truth]
) -> None:
    for number, shot in measured.items():
        for i, turned in enumerate(shot.orientations):
            true = [truths[number]["rotation_quaternion"][int(k)][i] for k in turned.frames]
            world = Rotation.from_quat(np.array(true), scalar_first=True)
            found = Rotation.from_matrix(turned.rotation)
            aligned = (world.inv() * found).mean()
            degrees = np.degrees((world * aligned * found.inv()).magnitude())
            assert degrees.max() < 3.0, (number, "ab"[i])


NUMBERS = {"v_n": "m/s", "v_s": "m/s", "v_n_after": "m/s", "v_s_after": "m/s", "e": "1"}


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The first two of the sample shots."""
    folder: Path = tmp_path_factory.mktemp("samples") / "pair"
    folder.mkdir()
    for name in ("campaign.toml", "frames"):
        (folder / name).symlink_to(SAMPLES / name)
    rows = (SAMPLES / "shots.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    (folder / "shots.csv").write_text("".join(rows[:3]), encoding="utf-8")
    return folder


@pytest.mark.long
def test_the_command_prints_one_document_of_the_promised_form(
    pair: Path, truths: dict[int, Truth]
) -> None:
    done = rigctl("analyse", str(pair), "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["campaign"] == "sample-shots"
    assert isinstance(document["method"], str)
    assert document["frames_per_second"] > 0
    assert [shot["shot"] for shot in document["shots"]] == [1, 2]
    for shot in document["shots"]:
        assert shot["status"] == "measured"
        truth = truths[shot["shot"]]
        assert shot["contact_time_s"] == pytest.approx(truth["contact_time_s"], abs=1e-4)
        assert shot["normal"] == pytest.approx(truth["normal"], abs=0.01)
        for name, unit in NUMBERS.items():
            assert set(shot[name]) == {"value", "sigma", "sigma_own", "sigma_common", "unit"}
            assert shot[name]["unit"] == unit
            true = truth.get(name, -truth["v_n_after"] / truth["v_n"])
            assert shot[name]["value"] == pytest.approx(true, abs=0.15)
        assert shot["beta"] is None or shot["beta"]["unit"] == "1"
        lasts = shot["contact_duration"]
        assert lasts["unit"] == "s"
        # These contacts are instantaneous.
        assert abs(lasts["value"]) < 3 * lasts["sigma"] < 1e-4


def test_a_film_of_which_nothing_is_measured_ends_with_2_and_its_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save(tmp_path / "0003.npy", np.full((8, 192, 240), 40, dtype=np.uint8))
    assert cli.run(["analyse", str(tmp_path / "0003.npy"), "--json"]) == 2
    shown = capsys.readouterr()
    (shot,) = json.loads(shown.out)["shots"]
    assert (shot["shot"], shot["status"]) == (3, "refused")
    assert shot["reason"] in shown.err
    # Perhaps it shows something else than two marked spheres.
    assert "--ball-diameter-mm" in shown.err
    assert shot["step"] in {"outlines", "assignment"}


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("absent", None, "absent"),
        ("campaign.toml", "format = 1\nname = 3\n", "name"),
    ],
)
def test_bad_input_ends_with_two_and_one_sentence_that_names_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, text: str | None, said: str
) -> None:
    if text is not None:
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert cli.run(["analyse", str(tmp_path if text else tmp_path / name), "--json"]) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert said in shown.err
    assert len(shown.err.strip().splitlines()) == 1
