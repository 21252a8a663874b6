"""Lines of the sensor that see nothing, against the same frames from a sound sensor."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from analysis.photometric.render.background import dead_lines, filled

NOISE, SHAPE, RADIUS = 2.0, (72, 96), 18.0


def flight(seed: int = 1) -> NDArray[np.uint8]:
    """Return a bright ball that crosses the frames from left to right, with soft edges."""
    rng = np.random.default_rng(seed)
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]]
    frames = []
    for column in np.linspace(20.0, 76.0, 12):
        rho = np.hypot(rows - 36.3, columns - column)
        light = 38.0 + 110.0 / (1.0 + np.exp((rho - RADIUS) / 0.6))
        frames.append(np.rint(light + NOISE * rng.normal(size=SHAPE)))
    return np.stack(frames).astype(np.uint8)


SOUND = flight()


@pytest.mark.parametrize("grey", [0, 40, 120, 255])
def test_dead_rows_are_found_at_any_grey_level(grey: int) -> None:
    frames = SOUND.copy()
    frames[:, [30, 45]] = grey
    rows, columns = dead_lines(frames, NOISE)
    assert rows.tolist() == [30, 45]
    assert columns.tolist() == []


@settings(deadline=None, max_examples=30)
@given(row=st.integers(22, 50), column=st.integers(24, 72))
def test_a_dead_row_and_a_dead_column_are_found_together(row: int, column: int) -> None:
    frames = SOUND.copy()
    frames[:, row] = 7
    frames[:, :, column] = 7
    rows, columns = dead_lines(frames, NOISE)
    assert (rows.tolist(), columns.tolist()) == ([row], [column])


def test_two_dead_rows_side_by_side_are_filled_within_the_bend_of_the_image() -> None:
    frames = SOUND.copy()
    frames[:, 36:38] = 0
    off = filled(frames, NOISE).astype(float) - SOUND
    assert np.sqrt((off[:, 36:38] ** 2).mean()) < 2.5 * NOISE
    assert not off[:, :36].any()
    assert not off[:, 38:].any()


@given(seed=st.integers(0, 20))
@settings(deadline=None, max_examples=10)
def test_frames_of_a_sound_sensor_come_back_untouched(seed: int) -> None:
    frames = flight(seed)
    assert filled(frames, NOISE) is frames


def test_a_dead_row_that_no_sphere_passes_is_left_alone() -> None:
    frames = SOUND.copy()
    frames[:, 5] = 0
    assert filled(frames, NOISE) is frames


def test_the_frames_that_were_given_are_not_changed() -> None:
    frames = SOUND.copy()
    frames[:, 30] = 0
    kept = frames.copy()
    filled(frames, NOISE)
    assert np.array_equal(frames, kept)
