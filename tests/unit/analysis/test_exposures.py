"""For how long a frame was open: what is stated, else what the camera's file says, else a step."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.campaign import THESIS_SETUP, ShotJob, read_job
from analysis.scene import Scene
from analysis.setup import NO_SLOW_ERRORS, Setup
from tests.unit.analysis.balls import test_camera_files as cameras


def stating(exposure_s: float | None) -> Setup:
    return replace(THESIS_SETUP, camera=replace(THESIS_SETUP.camera, exposure_s=exposure_s))


@pytest.mark.parametrize(("stated", "taken"), [(None, 5e-5), (2e-4, 2e-4)])
def test_the_exposure_in_a_header_is_taken_where_none_is_stated(
    tmp_path: Path, stated: float | None, taken: float
) -> None:
    values = np.full((cameras.FRAMES, cameras.ROWS, cameras.COLUMNS), 900, np.uint16)
    film = cameras.write_photron(tmp_path / "0001", values, 12)
    read = read_job(ShotJob(1, film, stating(stated)))
    assert read.setup == stating(taken)
    assert read.times_s == pytest.approx([0.0, 5e-4, 1e-3])


@pytest.mark.parametrize(
    ("stated", "step_s", "open_s"), [(None, 5e-4, 5e-4), (None, None, 1e-3), (1e-4, 5e-4, 1e-4)]
)
def test_a_frame_without_an_exposure_is_open_for_the_films_own_step(
    stated: float | None, step_s: float | None, open_s: float
) -> None:
    assert Scene.of(stating(stated), NO_SLOW_ERRORS, step_s).exposure_s == pytest.approx(open_s)
