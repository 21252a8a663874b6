"""poses.csv comes in as it was written, and every fault of it is named with its line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from analysis.errors import InputError
from analysis.exchange.pose_table import (
    POSES,
    POSES_SLOW,
    POSES_TURN,
    PoseRow,
    own_slow_errors,
    pose_writer,
    read_poses,
)
from analysis.setup import SlowErrors
from analysis.shot import MeasuredShot, analyse_shot
from simulators.world import WorldDescription
from tests.unit.analysis.rendered import setup_of, shot

HEADER = "shot,frame,t_s,sphere,x_m,y_m,z_m,sigma_x_m,sigma_y_m,sigma_z_m,qw,qx,qy,qz,sigma_rot_rad"
ROW = "1,0,0.0,a,0.1,0.2,0.3,1e-5,2e-5,3e-5,1,0,0,0,0.01"


def written(folder: Path, *lines: str) -> Path:
    path = folder / "poses.csv"
    path.write_text("\n".join([HEADER, *lines]) + "\n", encoding="utf-8")
    return path


def changed(**fields: str) -> str:
    row = dict(zip(HEADER.split(","), ROW.split(","), strict=True))
    assert set(fields) <= set(row)
    return ",".join((row | fields).values())


def test_a_row_is_read_into_si_units_and_rig_axes(tmp_path: Path) -> None:
    [pose] = read_poses(written(tmp_path, ROW))[1]["a"]
    assert pose == PoseRow(0, 0.0, (0.1, 0.2, 0.3), (1e-5, 2e-5, 3e-5), (1.0, 0.0, 0.0, 0.0), 0.01)


def test_a_shot_may_have_slow_errors_of_its_own(tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    path.write_text(f"{HEADER},slow_position_m,slow_rotation_rad\n{ROW},2e-5,3e-3\n")
    shots = read_poses(path)
    assert shots[1]["a"][0].slow == (2e-5, 3e-3)
    stated = SlowErrors(position_m=1e-6, scale=1e-3)
    own = own_slow_errors(shots[1], stated)
    assert (own.position_m, own.rotation_rad, own.scale) == (2e-5, 3e-3, 1e-3)
    assert own_slow_errors({"a": [], "b": []}, stated) == stated


def with_turn(folder: Path, sigma: str, *spread: str) -> Path:
    path = folder / "poses.csv"
    row = changed(sigma_rot_rad=sigma)
    path.write_text(f"{HEADER},{','.join(POSES_TURN)}\n{row},{','.join(spread)}\n")
    return path


def test_a_turn_may_be_known_less_about_one_axis(tmp_path: Path) -> None:
    spread = ("1e-4", "1e-4", "2.5e-3", "0", "3e-5", "-2e-5")
    [pose] = read_poses(with_turn(tmp_path, "0.03", *spread))[1]["a"]
    assert pose.turn_covariance == (1e-4, 1e-4, 2.5e-3, 0.0, 3e-5, -2e-5)
    [pose] = read_poses(with_turn(tmp_path, "0.03", *[""] * 6))[1]["a"]
    assert pose.turn_covariance is None


TURN_FAULTS = {
    "some fields empty": ("0.03", ("1e-4", "", "", "", "", ""), "all of them, or none"),
    "no covariance": ("0.01", ("1e-4", "1e-4", "1e-4", "2e-4", "0", "0"), "its least variance is"),
    "of another size": ("0.01", ("1e-4", "1e-4", "2.5e-3", "0", "0", "0"), "and 0.03 by the cov"),
    "without its size": ("", ("1e-4", "1e-4", "2.5e-3", "0", "0", "0"), "sigma_rot_rad is nan"),
}


@pytest.mark.parametrize("fault", TURN_FAULTS)
def test_a_false_covariance_of_a_turn_is_named_with_its_line(tmp_path: Path, fault: str) -> None:
    sigma, spread, reason = TURN_FAULTS[fault]
    with pytest.raises(InputError) as caught:
        read_poses(with_turn(tmp_path, sigma, *spread))
    assert caught.value.line == 2
    assert reason in caught.value.reason


def test_rows_in_any_order_come_back_by_shot_sphere_and_frame(tmp_path: Path) -> None:
    order = [("12", "3", "b"), ("2", "7", "a"), ("12", "1", "b"), ("2", "4", "a"), ("12", "1", "a")]
    shots = read_poses(
        written(tmp_path, *(changed(shot=s, frame=f, sphere=name) for s, f, name in order))
    )
    assert list(shots) == [2, 12]
    assert [pose.frame for pose in shots[2]["a"]] == [4, 7]
    assert [pose.frame for pose in shots[12]["b"]] == [1, 3]
    assert shots[2]["b"] == []


def test_columns_may_stand_in_any_order_and_blank_lines_are_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    lines = [",".join(reversed(line.split(","))) for line in (HEADER, ROW)]
    path.write_text(f"{lines[0]}\n\n{lines[1]}\n", encoding="utf-8")
    assert read_poses(path) == read_poses(written(tmp_path, ROW))


@pytest.mark.parametrize("field", ["qw", "qy"])
def test_an_orientation_with_an_empty_field_was_not_measured(tmp_path: Path, field: str) -> None:
    [pose] = read_poses(written(tmp_path, changed(**{field: ""})))[1]["a"]
    assert pose.quaternion is None
    assert pose.rotation_sigma == math.inf
    assert pose.position == (0.1, 0.2, 0.3)


@pytest.mark.parametrize("empty", ["", "0", "0.0"])
def test_an_error_that_is_empty_or_zero_is_not_stated(tmp_path: Path, empty: str) -> None:
    fields = changed(sigma_x_m=empty, sigma_rot_rad=empty)
    [pose] = read_poses(written(tmp_path, fields))[1]["a"]
    assert math.isnan(pose.position_sigma[0])
    assert math.isnan(pose.rotation_sigma)
    assert (pose.position[0], pose.quaternion) == (0.1, (1.0, 0.0, 0.0, 0.0))


def test_a_coordinate_with_an_empty_field_was_not_measured(tmp_path: Path) -> None:
    [pose] = read_poses(written(tmp_path, changed(y_m=" ")))[1]["a"]
    assert math.isnan(pose.position[1])
    assert pose.position_sigma == (1e-5, math.inf, 3e-5)
    assert pose.quaternion == (1.0, 0.0, 0.0, 0.0)


def test_a_table_with_its_heading_alone_holds_no_shot(tmp_path: Path) -> None:
    assert read_poses(written(tmp_path)) == {}


FAULTS = {
    "a field too few": (ROW.rpartition(",")[0], "14 fields for 15 columns"),
    "a third sphere": (changed(sphere="c"), "sphere: 'c' is neither a nor b"),
    "a shot that is no number": (changed(shot="first"), "shot: 'first' is not a whole number"),
    "a broken frame": (changed(frame="1.5"), "frame: '1.5' is not a whole number"),
    "no time": (changed(t_s=""), "t_s: empty"),
    "a word for a number": (changed(x_m="left"), "x_m: 'left' is not a number"),
    "not a number": (changed(z_m="nan"), "z_m: 'nan' is not finite"),
    "an infinite sigma": (changed(sigma_x_m="inf"), "sigma_x_m: 'inf' is not finite"),
    "a negative sigma": (changed(sigma_rot_rad="-1"), "sigma_rot_rad: -1.0 is not a standard"),
    "a long quaternion": (changed(qx="0.1"), "qw..qz: a quaternion of length 1.005, not 1"),
    "no quaternion at all": (changed(qw="0"), "qw..qz: a quaternion of length 0, not 1"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named_with_its_line(tmp_path: Path, fault: str) -> None:
    line, reason = FAULTS[fault]
    good = changed(frame="9")
    with pytest.raises(InputError) as caught:
        read_poses(written(tmp_path, good, "", line))
    assert caught.value.line == 4
    assert reason in caught.value.reason
    assert caught.value.path == str(tmp_path / "poses.csv")


@pytest.mark.parametrize("again", ["0", "00", " 0"])
def test_a_frame_that_stands_twice_is_refused_however_it_is_written(
    tmp_path: Path, again: str
) -> None:
    with pytest.raises(InputError, match="shot 1, frame 0, sphere a twice") as caught:
        read_poses(written(tmp_path, ROW, changed(sphere="b"), changed(frame=again)))
    assert caught.value.line == 4


@pytest.mark.parametrize(
    "heading", ["", HEADER.replace(",t_s", ""), HEADER + ",colour", HEADER.replace("x_m", "x_mm")]
)
def test_other_columns_are_refused_with_those_that_are_wanted(tmp_path: Path, heading: str) -> None:
    path = tmp_path / "poses.csv"
    path.write_text(heading, encoding="utf-8")
    with pytest.raises(InputError, match="the columns must be shot,frame,t_s,sphere") as caught:
        read_poses(path)
    assert caught.value.line == 1


def test_a_table_that_is_absent_or_not_text_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_poses(tmp_path / "poses.csv")
    (tmp_path / "poses.csv").write_bytes(HEADER.encode() + b"\n\xff\xfe\n")
    with pytest.raises(InputError, match="not CSV in UTF-8"):
        read_poses(tmp_path / "poses.csv")


@given(st.lists(st.floats(-1, 1), min_size=4, max_size=4))
def test_a_quaternion_written_in_full_comes_back_bit_for_bit_but_for_its_length(
    tmp_path_factory: pytest.TempPathFactory, parts: list[float]
) -> None:
    length = math.sqrt(sum(p * p for p in parts))
    if length < 0.1:
        parts, length = [1.0, 0.0, 0.0, 0.0], 1.0
    unit = [p / length for p in parts]
    line = changed(**dict(zip(("qw", "qx", "qy", "qz"), map(repr, unit), strict=True)))
    [pose] = read_poses(written(tmp_path_factory.mktemp("poses"), line))[1]["a"]
    assert pose.quaternion == pytest.approx(unit, abs=1e-15)


@pytest.fixture(scope="module")
def measured() -> MeasuredShot:
    rendered = shot(40.0, 6.0, frames=14)
    analysed = analyse_shot(rendered.frames, rendered.times_s, setup_of(WorldDescription()))
    assert isinstance(analysed, MeasuredShot)
    return analysed


def test_what_the_analysis_writes_comes_back_to_the_last_digit(
    tmp_path: Path, measured: MeasuredShot
) -> None:
    path = tmp_path / "poses.csv"
    with pose_writer(path) as write:
        write(7, measured)
    spheres = read_poses(path)[7]
    heading = path.read_text(encoding="utf-8").splitlines()[0].split(",")
    assert heading == [*POSES, *POSES_SLOW, *POSES_TURN]
    for name, centres, turned in zip("ab", measured.centres, measured.orientations, strict=True):
        rows = spheres[name]
        assert [row.frame for row in rows] == centres.frames.tolist()
        assert np.array([row.position for row in rows]).tolist() == centres.position.tolist()
        assert np.array([row.position_sigma for row in rows]).tolist() == centres.sigma.tolist()
        seen = [row for row in rows if row.quaternion is not None]
        assert [row.frame for row in seen] == turned.frames.tolist()
        read = Rotation.from_quat(np.array([row.quaternion for row in seen]), scalar_first=True)
        assert read.as_matrix() == pytest.approx(turned.rotation, abs=1e-12)
        spread = np.sqrt(np.trace(turned.covariance, axis1=1, axis2=2) / 3)
        assert [row.rotation_sigma for row in seen] == pytest.approx(spread, rel=1e-14)
        index = ([0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2])
        six = [each[index].tolist() for each in turned.covariance]
        assert [list(row.turn_covariance or ()) for row in seen] == six
