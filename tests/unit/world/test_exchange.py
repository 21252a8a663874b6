import csv
import json
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import tifffile

from simulators.world import write_campaign


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("exchange") / "nylon-9"
    write_campaign(folder, [30.0, 80.0], [4.0, 15.0], 11, frames=6, frame_rate_hz=500.0)
    return folder


def test_the_campaign_names_camera_spheres_and_environment(folder: Path) -> None:
    campaign = tomllib.loads((folder / "campaign.toml").read_text())
    assert campaign["format"] == 1
    assert campaign["name"] == "nylon-9"
    assert campaign["camera"]["frame_rate_hz"] == 500.0
    assert campaign["camera"]["front_origin_px"] == [132.0, 120.0]
    assert [sphere["name"] for sphere in campaign["spheres"]] == ["a", "b"]
    assert campaign["environment"]["gravity_m_per_s2"] == 9.80665


def test_each_shot_has_a_row_of_settings_and_a_stack_of_frames(folder: Path) -> None:
    with (folder / "shots.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["pressure_a_kpa"] for row in rows] == ["30.0", "80.0"]
    assert [row["offset_mm"] for row in rows] == ["4.0", "15.0"]
    for shot in (1, 2):
        stack = tifffile.imread(folder / "frames" / f"{shot:04d}.tiff")
        assert stack.shape == (6, 192, 240)
        assert stack.dtype == np.uint8


def test_the_truth_holds_markers_contacts_and_poses(folder: Path) -> None:
    truth = json.loads((folder / "truth.json").read_text())
    assert np.array(truth["spheres"][0]["markers_body"]).shape == (16, 3)
    assert [shot["shot"] for shot in truth["shots"]] == [1, 2]
    assert all(len(shot["rotation_quaternion"]) == 6 for shot in truth["shots"])
    assert truth["shots"][1]["v_n"] < truth["shots"][0]["v_n"] < 0.0


def test_no_two_shots_share_their_noise(folder: Path) -> None:
    corners = [
        tifffile.imread(folder / "frames" / f"{shot:04d}.tiff")[0, -20:, -20:] for shot in (1, 2)
    ]
    assert np.any(corners[0] != corners[1])


def test_lists_of_unequal_length_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="shorter"):
        write_campaign(tmp_path, [30.0, 40.0], [4.0], 1)


def test_the_command_writes_a_folder(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "simulators.world", str(tmp_path / "out")]
    subprocess.run([*command, "--shots", "1", "--frames", "2"], check=True, timeout=60)
    assert (tmp_path / "out" / "frames" / "0001.tiff").exists()
