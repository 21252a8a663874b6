"""The runs on the simulated apparatus: what the thesis reached, and what is asked of us."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.errors import ShotRefusedError
from analysis.qualification.depth import measure_both_ways
from analysis.qualification.disk import disk_markers, measure_disk, plane_angle
from analysis.qualification.drop import gravity, measure_fall
from analysis.qualification.figures import DEVIATIONS_DEG, drop_mean_and_deviation, z_errors
from analysis.qualification.locating import find_disc, locate
from analysis.qualification.stage import measure_stage
from rigctl.cli.frames.qualify_sources import setup_of
from simulators.qualification import filmed_drop, filmed_shot, stage_run, turning_disk

pytestmark = pytest.mark.long


def test_subpixel_edges_beat_pixels_shells_beat_hough_and_grey_levels_beat_all() -> None:
    run = stage_run((1.0, 1.0), 1)
    rms = {error.way: error.rms_px for error in measure_stage(run.frames, run.moved_px)}
    assert rms["photometric"] < rms["quarters"] < rms["pixel"] < rms["aht"]
    assert rms["exact"] < 0.012
    assert rms["photometric"] < 0.008
    assert max(rms["sobel"], rms["canny"]) < 0.08
    assert rms["aht"] < 0.25


@pytest.mark.parametrize(("direction", "name"), [((0.0, 1.0), "x"), ((1.0, 0.0), "y")])
def test_errors_are_those_of_the_moved_coordinate_about_the_mean(
    direction: tuple[float, float], name: str
) -> None:
    run = stage_run(direction, 2)
    (error,) = measure_stage(run.frames, run.moved_px, ("exact",))
    assert error.direction == name
    assert error.errors_px.shape == (9, 1)
    assert error.errors_px.mean() == pytest.approx(0.0, abs=1e-12)
    assert error.rms_px == pytest.approx(np.std(error.errors_px, ddof=1))
    assert error.largest_px == np.abs(error.errors_px).max()


def test_gravity_by_grey_levels_is_right_to_a_thousandth_and_scatters_by_less() -> None:
    drops = [filmed_drop(seed) for seed in range(3)]
    falls = [measure_fall(one.frames, one.times_s, "photometric") for one in drops]
    found = gravity(falls, drops[0].diameter_m, drops[0].gravity_m_per_s2)
    assert abs(found.bias) < 1e-3
    assert found.deviation / found.true < 1e-3
    assert found.scale_px_per_m == pytest.approx(33.0 / 0.0254, rel=1.5e-3)


def test_the_thesis_method_scatters_less_than_the_thesis_and_errs_by_its_scale_alone() -> None:
    drops = [filmed_drop(seed) for seed in range(3)]
    falls = [measure_fall(one.frames, one.times_s, "thesis") for one in drops]
    found = gravity(falls, drops[0].diameter_m, drops[0].gravity_m_per_s2)
    assert found.deviation < drop_mean_and_deviation()[1]
    with_true_scale = found.mean * found.scale_px_per_m * 0.0254 / 33.0
    assert with_true_scale == pytest.approx(found.true, rel=5e-4)


@pytest.mark.parametrize("method", ["thesis", "photometric"])
def test_angles_of_the_disk_are_within_a_twentieth_of_a_per_cent(method) -> None:
    run = turning_disk(3)
    turns = measure_disk(run.frames, run.turn_rad, method)
    assert [len(turn.angles) for turn in turns] == [14, 13, 12, 11, 10, 9, 8]
    for turn, printed in zip(turns, DEVIATIONS_DEG, strict=True):
        assert abs(turn.relative_error) < 5e-4
        assert turn.deviation < 0.05 < printed


@given(
    angle=st.floats(-3.1, 3.1),
    row=st.floats(-50, 50),
    column=st.floats(-50, 50),
    size=st.integers(2, 6),
)
def test_a_turned_and_shifted_set_of_points_gives_its_angle(
    angle: float, row: float, column: float, size: int
) -> None:
    points = np.random.default_rng(size).uniform(-30, 30, (size, 2))
    c, s = math.cos(angle), math.sin(angle)
    turned = points @ np.array([[c, s], [-s, c]]) + [row, column]
    found = plane_angle(points, turned)
    assert abs((found - angle + math.pi) % (2 * math.pi) - math.pi) < 1e-9


def test_a_disk_without_markers_is_refused() -> None:
    with pytest.raises(ShotRefusedError, match="0 markers are seen in all 4 frames"):
        disk_markers(np.full((4, 96, 120), 90, np.uint8), "thesis")


def test_too_short_a_fall_and_an_empty_frame_are_refused() -> None:
    one = filmed_drop(0)
    with pytest.raises(ShotRefusedError, match="4 frames, 5 are needed"):
        measure_fall(one.frames[:4], one.times_s[:4], "thesis")
    with pytest.raises(ShotRefusedError, match="no disc"):
        find_disc(np.full((96, 120), 40, np.uint8), 8.0, 40.0)


def test_a_circle_that_is_not_there_is_refused_by_the_hough_transform() -> None:
    frames = np.full((1, 96, 120), 40, np.uint8)
    with pytest.raises(ShotRefusedError, match="finds no circle"):
        locate(frames, [(48.0, 60.0, 20.0)], "aht")


def test_frames_that_show_nothing_refuse_both_ways() -> None:
    filmed = filmed_shot(0, 0)
    blank = np.full_like(filmed.frames, 40)
    assert not measure_both_ways(blank, filmed.times_s, setup_of(filmed), "thesis")


def test_table_3_3_implies_what_is_printed_up_to_sign_and_an_error_of_e_above_half_a_per_cent() -> (
    None
):
    errors = z_errors()
    printed = {"v_n": 0.38, "v_n_after": 0.47, "v_s": 0.05, "v_s_after": 0.05}
    for name, per_cent in printed.items():
        assert abs(100 * errors[name]) == pytest.approx(per_cent, abs=0.006)
    assert 100 * errors["e"] == pytest.approx(-0.85, abs=0.005)
