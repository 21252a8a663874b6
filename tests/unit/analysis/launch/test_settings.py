"""Settings of a campaign: their history, from covariates and from the list of shots."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.errors import InputError, LaunchRefusedError
from analysis.launch.settings import LaunchSettings, in_turn, read_settings, settings_of
from tests.unit.analysis.model.hard_spheres import campaign

HEADER = "shot,time,pressure_a_kpa,pressure_b_kpa,offset_mm"


def written(folder: Path, *rows: str, header: str = HEADER) -> Path:
    path = folder / "shots.csv"
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def turned(pressures: list[float], offsets: list[float]) -> LaunchSettings:
    return in_turn(np.array([pressures, pressures]).T, np.array(offsets))


def test_a_setting_that_stays_keeps_the_direction_it_was_reached_from() -> None:
    settings = turned([20, 40, 40, 30, 30], [0, 0, 2, 2, 1])
    assert settings.pressure_step[:, 0].tolist() == [0, 1, 1, -1, -1]
    assert settings.slide_step.tolist() == [0, 0, 1, 1, -1]


def test_history_follows_the_time_of_firing_not_the_numbers(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        "1,2026-01-01T09:02:00Z,30,30,4",
        "2,2026-01-01T09:00:00Z,20,50,2",
        "3,2026-01-01T09:01:30Z,40,40,6",
    )
    found = read_settings(path, np.array([1, 2, 3]))
    assert found.pressure_step.tolist() == [[-1, -1], [0, 0], [1, -1]]
    assert found.slide_step.tolist() == [-1, 0, 1]
    assert found.waited_s.tolist() == [30.0, 0.0, 90.0]
    assert found.offset_m.tolist() == [0.004, 0.002, 0.006]


def test_shots_without_poses_count_in_the_history(tmp_path: Path) -> None:
    rows = ("1,,20,20,0", "2,,90,90,0", "3,,40,40,0")
    found = read_settings(written(tmp_path, *rows), np.array([1, 3]))
    assert found.pressure_kpa[:, 0].tolist() == [20, 40]
    assert found.pressure_step[:, 0].tolist() == [0, -1]


def test_a_shot_without_poses_may_lack_settings(tmp_path: Path) -> None:
    rows = ("1,,20,20,0", "2,,,,", "3,,40,40,0")
    found = read_settings(written(tmp_path, *rows), np.array([1, 3]))
    assert found.pressure_step[:, 0].tolist() == [0, 1]


def test_delays_and_noted_waits_are_read(tmp_path: Path) -> None:
    header = HEADER + ",delay_us,wait_s"
    path = written(tmp_path, "1,,20,20,0,250,7", "2,,20,20,0,-100,9", header=header)
    found = read_settings(path, np.array([1, 2]))
    assert found.delay_s == pytest.approx([2.5e-4, -1e-4])
    assert found.waited_s.tolist() == [7, 9]


def test_without_times_no_wait_is_known(tmp_path: Path) -> None:
    found = read_settings(written(tmp_path, "1,,20,20,0", "2,,30,30,0"), np.array([1, 2]))
    assert found.waited_s.tolist() == [0, 0]


def test_a_measured_shot_without_a_pressure_is_named(tmp_path: Path) -> None:
    path = written(tmp_path, "1,,20,20,0", "2,,,20,0")
    with pytest.raises(InputError, match="shot 2 has no pressure_a_kpa"):
        read_settings(path, np.array([1, 2]))


def test_poses_of_a_shot_that_is_not_listed_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"stand in no row: \[7\]"):
        read_settings(written(tmp_path, "1,,20,20,0"), np.array([1, 7]))


def test_covariates_give_the_same_settings_in_the_order_of_firing() -> None:
    data = campaign(3, 1)
    covariates = {
        "order": np.array([0.5, -0.5, 0.0]),
        "pressure_a_kpa": np.array([30.0, 20.0, 40.0]),
        "pressure_b_kpa": np.array([30.0, 50.0, 40.0]),
        "offset_mm": np.array([4.0, 2.0, 6.0]),
        "delay_us": np.array([100.0, 0.0, 0.0]),
    }
    found = settings_of(replace(data, covariates=covariates))
    assert found.pressure_step.tolist() == [[-1, -1], [0, 0], [1, -1]]
    assert found.slide_step.tolist() == [-1, 0, 1]
    assert found.delay_s == pytest.approx([1e-4, 0, 0])


def test_a_campaign_without_settings_is_refused_with_what_it_lacks() -> None:
    with pytest.raises(LaunchRefusedError, match="pressure_a_kpa, pressure_b_kpa, offset_mm"):
        settings_of(campaign(3, 1))
