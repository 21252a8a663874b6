"""A campaign folder becomes the arrays that are fitted, and nothing of it is lost or made up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.errors import InputError
from analysis.exchange.pose_table import measured_poses, pose_writer, read_poses
from analysis.model.data.gather import gather
from analysis.model.data.poses import PoseData
from analysis.model.fitting.robust_fit import NOT_SHOWN, robust_fit
from analysis.shot import MeasuredShot, analyse_shot
from simulators.world import WorldDescription
from tests.unit.analysis.model.exchange_folder import write_campaign
from tests.unit.analysis.model.hard_spheres import POSITION_SIGMA, campaign
from tests.unit.analysis.rendered import setup_of, shot


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_campaign(tmp_path / "campaign", campaign(4, 11))


def rewrite(folder: Path, keep: Callable[..., bool]) -> None:
    path = folder / "poses.csv"
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    kept = [row for row in rows if keep(*row.split(",")[:4])]
    path.write_text("\n".join([head, *kept]) + "\n", encoding="utf-8")


def list_shots(folder: Path, *lines: str) -> None:
    (folder / "shots.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def test_all_poses_come_back_as_they_were_written(folder: Path) -> None:
    name, data = gather(folder)
    true = campaign(4, 11)
    assert name == "hard spheres"
    assert data.shots.tolist() == [1, 2, 3, 4]
    assert np.array_equal(data.times_s, true.times_s)
    assert np.array_equal(data.position, true.position)
    assert np.array_equal(data.position_sigma, true.position_sigma)
    assert np.array_equal(data.rotation_sigma, true.rotation_sigma)
    assert data.rotation == pytest.approx(true.rotation, abs=1e-12)
    assert data.bodies == true.bodies
    assert (data.gravity, data.air_density) == (9.80665, 1.2)
    assert data.camera == true.camera


def test_the_order_of_firing_is_that_of_the_clock_not_of_the_numbers(folder: Path) -> None:
    minutes = {1: 30, 2: 5, 3: 45, 4: 10}
    rows = [f"{shot},2026-01-01T09:{minute:02}:00Z" for shot, minute in minutes.items()]
    list_shots(folder, "shot,time", *rows)
    _, data = gather(folder)
    assert data.covariates["order"].tolist() == pytest.approx([1 / 6, -1 / 2, 1 / 2, -1 / 6])


def test_without_all_times_the_order_is_that_of_the_numbers(folder: Path) -> None:
    list_shots(folder, "shot,time", "1,2026-01-01T12:00:00Z", "2,", "3,2026-01-01T09:00:00Z", "4,")
    _, data = gather(folder)
    assert data.covariates["order"].tolist() == pytest.approx([-1 / 2, -1 / 6, 1 / 6, 1 / 2])


def test_a_numeric_column_is_a_covariate_where_every_shot_has_it(folder: Path) -> None:
    heading = "shot,offset_mm,humidity,operator"
    list_shots(folder, heading, "4,8,,Ana", "3,6,40,Ana", "2,4,41,Ben", "1,2,42,Ana")
    _, data = gather(folder)
    assert set(data.covariates) == {"offset_mm", "order"}
    assert data.covariates["offset_mm"].tolist() == [2, 4, 6, 8]


def test_a_listed_shot_without_poses_is_passed_over(folder: Path) -> None:
    list_shots(folder, "shot,offset_mm", "1,2", "2,4", "3,6", "4,8", "5,")
    _, data = gather(folder)
    assert data.shots.tolist() == [1, 2, 3, 4]
    assert data.covariates["offset_mm"].tolist() == [2, 4, 6, 8]


def test_poses_of_a_shot_that_is_not_listed_leave_only_the_order_as_covariate(folder: Path) -> None:
    list_shots(folder, "shot,offset_mm", "1,2", "2,4", "4,8")
    _, data = gather(folder)
    assert data.shots.tolist() == [1, 2, 3, 4]
    assert set(data.covariates) == {"order"}


def test_a_shorter_shot_is_filled_up_with_what_was_not_measured(folder: Path) -> None:
    rewrite(folder, lambda shot, frame, *_: shot != "3" or 2 <= int(frame) < 17)
    _, data = gather(folder)
    assert data.times_s.shape == (4, 24)
    assert data.measured[2, :15].all()
    assert not data.measured[2, 15:].any()
    assert np.array_equal(data.position[2, :15], campaign(4, 11).position[2, 2:17])
    assert np.isfinite(data.position).all()
    assert (np.diff(data.times_s[2]) >= 0).all()


def test_a_sphere_missing_in_a_frame_leaves_the_other_where_it_was(folder: Path) -> None:
    rewrite(folder, lambda shot, frame, _, sphere: (shot, frame, sphere) != ("2", "5", "a"))
    _, data = gather(folder)
    assert data.measured.sum() == 4 * 24 * 12 - 6
    assert not data.measured[1, 5, 0].any()
    assert np.array_equal(data.position[1, 5, 1], campaign(4, 11).position[1, 5, 1])


def test_an_orientation_that_was_not_measured_is_one_all_the_same(tmp_path: Path) -> None:
    data = campaign(3, 12)
    sigma = data.rotation_sigma.copy()
    sigma[1, 4, 0] = np.inf
    written = write_campaign(tmp_path / "c", replace(data, rotation_sigma=sigma))
    _, read = gather(written)
    assert not read.measured[1, 4, 0, 3:].any()
    assert read.measured[1, 4, 0, :3].all()
    assert Rotation.from_matrix(read.rotation[1, 4, 0]).magnitude() == 0


def test_the_exposure_of_the_shots_is_that_of_the_camera(folder: Path) -> None:
    list_shots(folder, "shot,exposure_us", "1,120", "2,120", "3,250", "4,120", "9,900")
    _, data = gather(folder)
    assert data.camera.exposure_s == pytest.approx(250e-6)


def test_a_shot_measured_now_gives_what_its_written_table_gives(tmp_path: Path) -> None:
    rendered = shot(40.0, 6.0, frames=14)
    measured = analyse_shot(rendered.frames, rendered.times_s, setup_of(WorldDescription()))
    assert isinstance(measured, MeasuredShot)
    with pose_writer(tmp_path / "poses.csv") as write:
        write(1, measured)
    now, read = measured_poses(measured), read_poses(tmp_path / "poses.csv")[1]
    for name in "ab":
        for mine, written in zip(now[name], read[name], strict=True):
            assert mine.quaternion == pytest.approx(written.quaternion, abs=1e-15)
            assert replace(mine, quaternion=None) == replace(written, quaternion=None)


def test_a_table_without_poses_is_refused(folder: Path) -> None:
    rewrite(folder, lambda *_: False)
    with pytest.raises(
        InputError, match="no shot of this campaign has 2 frames or more that show both"
    ):
        gather(folder)


def test_a_folder_without_a_description_is_refused_by_the_name_of_the_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"campaign\.toml: no such file"):
        gather(tmp_path)


def test_errors_that_nobody_stated_are_those_of_the_scatter(tmp_path: Path) -> None:
    data = campaign(20, 31)
    folder = write_campaign(tmp_path / "c", data)
    path = folder / "poses.csv"
    header, *lines = path.read_text(encoding="utf-8").splitlines()
    names = header.split(",")
    bare = [
        ",".join(
            "" if n.startswith("sigma") else f for n, f in zip(names, line.split(","), strict=True)
        )
        for line in lines
    ]
    path.write_text("\n".join([header, *bare]) + "\n", encoding="utf-8")
    _, read = gather(folder)
    assert read.estimated
    found = robust_fit(read)
    assert found.fit.chi2_per_dof == pytest.approx(1.0, abs=0.05)
    sigma = found.data.position_sigma[np.isfinite(found.data.position_sigma)]
    assert sigma == pytest.approx(POSITION_SIGMA, rel=0.05)
    with_errors = robust_fit(data).fit.parameters()["e"]
    e = found.fit.parameters()["e"]
    assert e.value == pytest.approx(with_errors.value, abs=with_errors.sigma)


def test_a_shot_that_never_shows_both_spheres_is_left_out_and_named(folder: Path) -> None:
    rewrite(folder, lambda shot, frame, t, sphere: not (shot == "2" and sphere == "a"))
    _, data = gather(folder)
    assert data.shots.tolist() == [1, 3, 4]
    assert data.unusable == (2,)
    assert robust_fit(data).rejected_why == {2: NOT_SHOWN}


def test_without_a_top_view_the_rest_is_fitted(tmp_path: Path) -> None:
    data = campaign(30, 12)
    sigma = data.position_sigma.copy()
    sigma[..., 2] = np.inf
    flat = replace(data, position_sigma=sigma, position=data.position * np.array([1, 1, 0]))
    e = robust_fit(gather(write_flat(tmp_path / "c", flat))[1]).fit.parameters()["e"]
    assert e.value == pytest.approx(0.74, abs=4 * e.sigma)
    assert e.sigma < 0.005


def write_flat(folder: Path, data: PoseData) -> Path:
    """Write a campaign whose depth nobody measured."""
    whole = replace(data, position_sigma=np.where(np.isinf(data.position_sigma), 1.0, 2e-5))
    write_campaign(folder, whole)
    path = folder / "poses.csv"
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    blank = {head.split(",").index(name) for name in ("z_m", "sigma_z_m")}
    kept = [",".join("" if k in blank else f for k, f in enumerate(row.split(","))) for row in rows]
    path.write_text("\n".join([head, *kept]) + "\n", encoding="utf-8")
    return folder
