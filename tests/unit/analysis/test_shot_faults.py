"""Frames that lie about time or size are refused by name, never measured with a small error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.exchange.pose_table import POSES, pose_writer
from analysis.setup import Setup
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot, analyse_shot
from simulators.world import Launch, WorldDescription, render_shot
from tests.unit.analysis.rendered import setup_of


@pytest.fixture(scope="module")
def setup() -> Setup:
    return setup_of(WorldDescription())


@pytest.fixture(scope="module")
def frames() -> np.ndarray:
    return render_shot(WorldDescription(), Launch(55.0, 55.0, 0.008), 11).frames


def analysed(
    frames: np.ndarray, setup: Setup, options: AnalysisOptions | None = None
) -> MeasuredShot | RefusedShot:
    return analyse_shot(frames, np.arange(len(frames)) * 1e-3, setup, options)


def test_the_shot_itself_is_measured(frames, setup) -> None:
    assert isinstance(analysed(frames, setup), MeasuredShot)


@pytest.mark.parametrize("lost", [4, 6, 17])
def test_a_frame_lost_without_a_word_is_refused_near_where_it_was(frames, setup, lost) -> None:
    shot = analysed(np.delete(frames, lost, axis=0), setup)
    assert isinstance(shot, RefusedShot)
    assert shot.step == "motion"
    assert shot.frame is not None


def test_a_repeated_frame_is_refused_with_its_number(frames, setup) -> None:
    repeated = frames.copy()
    repeated[6] = repeated[5]
    shot = analysed(repeated, setup)
    assert isinstance(shot, RefusedShot)
    assert (shot.step, shot.frame) == ("frames", 6)


def test_exchanged_frames_are_refused(frames, setup) -> None:
    order = list(range(len(frames)))
    order[5], order[6] = order[6], order[5]
    assert isinstance(analysed(frames[order], setup), RefusedShot)


def test_frames_played_backwards_would_gain_energy_and_are_refused(frames, setup) -> None:
    shot = analysed(frames[::-1].copy(), setup)
    assert isinstance(shot, RefusedShot)
    assert "no contact can" in shot.reason


@pytest.mark.parametrize("factor", [0.95, 1.05])
def test_a_stated_scale_that_the_images_contradict_is_refused(frames, setup, factor) -> None:
    camera = replace(setup.camera, scale_px_per_m=factor * 1574.8)
    shot = analysed(frames, replace(setup, camera=camera))
    assert isinstance(shot, RefusedShot)
    assert shot.step == "outlines"
    assert "scale_px_per_m" in shot.reason


def test_a_true_stated_scale_is_used(frames, setup) -> None:
    camera = replace(setup.camera, scale_px_per_m=1574.8)
    assert isinstance(analysed(frames, replace(setup, camera=camera)), MeasuredShot)


def test_a_frame_that_shows_nothing_is_left_out_and_noted(frames, setup) -> None:
    dark = frames.copy()
    dark[4] = 0
    shot = analysed(dark, setup)
    assert isinstance(shot, MeasuredShot)
    assert any(note.startswith("frame 4 shows no outline of sphere a") for note in shot.notes)


def test_times_that_disagree_with_the_frame_rate_are_believed_and_noted(frames, setup) -> None:
    shot = analyse_shot(frames, np.arange(len(frames)) * 1.05e-3, setup)
    assert isinstance(shot, MeasuredShot)
    assert any("1.05 ms apart" in note for note in shot.notes)


def test_frames_that_no_rendering_explains_are_left_out(frames, setup) -> None:
    hidden = frames.copy()
    hidden[18:, :88] = 40
    shot = analysed(hidden, setup)
    assert isinstance(shot, MeasuredShot)
    assert shot.centres[0].frames[-1] < 18
    whole = analysed(frames, setup)
    assert isinstance(whole, MeasuredShot)
    off = shot.impact.e.value - whole.impact.e.value
    assert abs(off) < 5 * np.hypot(shot.impact.e.sigma, whole.impact.e.sigma)


def test_a_sphere_hidden_in_the_mirror_keeps_its_front_view(frames, setup, tmp_path) -> None:
    hidden = frames.copy()
    hidden[18:, :88] = 40
    shot = analysed(hidden, setup, AnalysisOptions(method="thesis"))
    assert isinstance(shot, MeasuredShot)
    last = int(shot.centres[0].frames[-1])
    assert last >= 18
    assert np.isinf(shot.centres[0].sigma[-1, 2])
    with pose_writer(tmp_path / "poses.csv") as write:
        write(1, shot)
    rows = (tmp_path / "poses.csv").read_text().splitlines()
    row = next(r.split(",") for r in rows if r.startswith(f"1,{last},") and ",a," in r)
    assert row[POSES.index("z_m")] == row[POSES.index("sigma_z_m")] == ""
    assert row[POSES.index("x_m")] != ""
