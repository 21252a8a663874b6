"""`rigctl qualify --frames`: files of one's own apparatus give what the same frames give inside."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
from numpy.typing import NDArray

from rigctl import cli
from simulators.qualification import drop, filmed_drop, stage_run, turning_disk
from simulators.world import write_campaign

Json = dict[str, Any]


def film(path: Path, frames: NDArray[np.uint8]) -> str:
    tifffile.imwrite(path, frames, photometric="minisblack", metadata=None)
    return str(path)


def document(capsys: pytest.CaptureFixture[str], *arguments: str) -> Json:
    assert cli.run(["qualify", *arguments, "--json"]) == 0
    found: Json = json.loads(capsys.readouterr().out)
    return found


def test_a_disk_of_a_file_is_measured_against_its_meter(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = film(tmp_path / "disk.tiff", turning_disk(3).frames)
    settings = ("--rpm", "997", "--fps", "1000", "--method", "thesis")
    found = document(capsys, "disk", "--frames", path, *settings)
    turns = found["methods"]["thesis"]
    assert [turn["actual_deg"] for turn in turns] == pytest.approx(
        [997 / 60 * 360 / 1000 * steps for steps in range(1, 8)]
    )
    good_for = found["good_for"]
    assert good_for["angle_sigma_deg"] == pytest.approx(turns[0]["deviation_deg"] / np.sqrt(2))
    assert abs(good_for["rate_bias"]) < 5e-4
    assert "a spin from 10 frames" in good_for["sentence"]
    assert found["of"] == path


def test_a_clock_that_is_wrong_by_one_per_cent_is_seen_on_the_disk(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = film(tmp_path / "disk.tiff", turning_disk(3).frames)
    settings = ("--rpm", "997", "--fps", "990", "--method", "thesis")
    found = document(capsys, "disk", "--frames", path, *settings)
    assert found["good_for"]["rate_bias"] == pytest.approx(990 / 1000 - 1, abs=5e-4)


def test_pictures_of_a_stage_are_measured_against_its_steps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = stage_run((1.0, 0.0), 5)
    path = film(tmp_path / "stage.tiff", run.frames)
    settings = ("--step-px", "0.25", "--direction", "y", "--method", "photometric")
    found = document(capsys, "stage", "--frames", path, *settings)
    (error,) = found["errors"]
    assert error["direction"] == "y"
    assert error["rms_px"] < 0.02
    assert found["good_for"]["centre_rms_px"] == error["rms_px"]
    assert found["good_for"]["way_share"] == pytest.approx(1.0, abs=0.02)
    assert "correct the step" not in found["good_for"]["sentence"]


def test_steps_that_are_stated_wrong_are_errors_of_the_stage(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = film(tmp_path / "stage.tiff", stage_run((0.0, 1.0), 5).frames)
    settings = ("--step-px", "0.30", "--method", "photometric")
    found = document(capsys, "stage", "--frames", path, *settings)
    # Nine places with 0.05 px too much a step: sqrt(60 / 8) steps of rms, the mean taken out.
    assert found["errors"][0]["rms_px"] == pytest.approx(0.05 * np.sqrt(60 / 8), rel=0.05)
    assert found["good_for"]["way_share"] == pytest.approx(0.25 / 0.30, rel=0.01)
    assert "moved by 0.83" in found["good_for"]["sentence"]


def test_of_a_fall_only_frames_count_that_show_the_whole_sphere(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fallen = filmed_drop(2)
    empty = np.clip(np.random.default_rng(1).normal(35.0, 1.5, (3, 192, 240)), 0, 255)
    cut = np.roll(fallen.frames[:1], -20, axis=1)
    frames = np.concatenate([empty.astype(np.uint8), cut, fallen.frames])
    path = film(tmp_path / "drop.tiff", frames)
    settings = ("--ball-diameter-mm", "25.4", "--fps", "125", "--gravity-m-per-s2", "9.80236")
    found = document(capsys, "drop", "--frames", path, *settings, "--method", "photometric")
    own = found["methods"]["photometric"]
    assert own["mean_m_per_s2"] == pytest.approx(drop.GRAVITY_M_PER_S2, rel=2e-3)
    assert found["good_for"]["speed_bias"] == pytest.approx(own["bias"])
    assert 0.001 < found["good_for"]["place_sigma_px"] < 0.03


def test_a_person_reads_what_the_camera_is_good_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = film(tmp_path / "disk.tiff", turning_disk(3).frames)
    settings = ["--rpm", "997", "--fps", "1000", "--method", "thesis"]
    assert cli.run(["qualify", "disk", "--frames", path, *settings]) == 0
    assert "A frame's angle is good to 0.00" in capsys.readouterr().out


@pytest.mark.long
@pytest.mark.timeout(600)
def test_shots_of_a_campaign_folder_are_measured_with_and_without_the_mirror(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_campaign(tmp_path / "own", [40.0], [16.0], seed=2)
    found = document(capsys, "depth", "--frames", str(tmp_path / "own"))
    assert len(found["shots"]) == 1
    assert 0.0 < found["good_for"]["e_change"] < 0.02


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("drop", "--frames", "film.tiff"), "--ball-diameter-mm: is needed"),
        (("disk", "--rpm", "997"), "--rpm: is for frames of your own"),
        (("disk", "--frames", "film.tiff", "--rpm", "997"), "state --fps"),
        (("stage", "--frames", "none.tiff", "--step-px", "1"), "no such file"),
        (("depth", "--frames", "film.tiff"), "holds neither campaign.toml nor manifest.json"),
    ],
)
def test_what_is_missing_is_said_with_what_to_state(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    film(tmp_path / "film.tiff", np.zeros((6, 192, 240), np.uint8))
    assert cli.run(["qualify", *arguments]) == cli.BAD_INPUT
    assert said in capsys.readouterr().err


def test_a_film_without_a_sphere_is_refused_with_what_is_needed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = film(tmp_path / "film.tiff", np.full((6, 192, 240), 30, np.uint8))
    settings = ["--ball-diameter-mm", "25.4", "--fps", "250"]
    assert cli.run(["qualify", "drop", "--frames", path, *settings]) == cli.BAD_INPUT
    assert "0 frames in a row show a whole sphere" in capsys.readouterr().err
