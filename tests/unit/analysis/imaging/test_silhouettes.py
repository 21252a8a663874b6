"""Discs that fly before a scene with edges of its own, drawn by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import ndimage

from analysis.photometric.follow.first_tracking import silhouettes, still_scene

ROWS, COLUMNS, FRAMES = 80, 160, 24
NOISE = 2.0
RADIUS = 20.0


def wall(seed: int) -> NDArray[np.float64]:
    """Return blotches that are as bright as the disc here and black there."""
    rough = np.random.default_rng(seed).standard_normal((ROWS, COLUMNS))
    blotches = ndimage.gaussian_filter(rough, 2.0)
    return np.asarray(60.0 + 30.0 * blotches / blotches.std())


def shaded_disc(row: float, column: float) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Return where a disc is, and the light of one that is lit from the left."""
    down, across = np.mgrid[:ROWS, :COLUMNS]
    within = np.hypot(down - row, across - column) <= RADIUS
    return within, 90.0 - 3.0 * (across - column)


def film(step_px: float, seed: int) -> NDArray[np.uint8]:
    """Return a disc that flies from left to right before the wall."""
    chance = np.random.default_rng(seed + 1)
    frames = []
    for k in range(FRAMES):
        within, light = shaded_disc(40.0, column_at(k, step_px))
        scene = np.where(within, light, wall(seed)) + NOISE * chance.standard_normal(
            (ROWS, COLUMNS)
        )
        frames.append(np.clip(np.rint(scene), 0, 255).astype(np.uint8))
    return np.stack(frames)


def column_at(frame: int, step_px: float) -> float:
    return COLUMNS / 2 + step_px * (frame - FRAMES / 2)


def test_the_scene_is_found_where_a_disc_covers_it_in_more_than_half_of_the_frames() -> None:
    # 40 px of disc at 2.6 px a frame: the middle is covered in 15 frames of 24.
    found = still_scene(film(2.6, 3))[40]
    truth = np.clip(wall(3), 0.0, 255.0)[40]
    assert np.median(np.abs(found - truth)) < NOISE
    assert np.mean(np.abs(found - truth) > 5.0 * NOISE) < 0.03


@settings(max_examples=10, deadline=None)
@given(st.floats(2.8, 5.0), st.integers(0, 100))
def test_a_flying_disc_stands_out_as_large_and_where_it_is(step_px: float, seed: int) -> None:
    seen = silhouettes(film(step_px, seed), NOISE)
    down, across = np.mgrid[:ROWS, :COLUMNS]
    for k in (6, 12, 18):
        bright = seen[k] > 100
        assert bright.sum() == pytest.approx(np.pi * RADIUS**2, rel=0.15)
        assert down[bright].mean() == pytest.approx(40.0, abs=1.0)
        assert across[bright].mean() == pytest.approx(column_at(k, step_px), abs=1.0)


def test_a_scene_in_which_nothing_moves_has_no_silhouette() -> None:
    chance = np.random.default_rng(5)
    noise = NOISE * chance.standard_normal((FRAMES, ROWS, COLUMNS))
    frames = np.clip(np.rint(wall(5) + noise), 0, 255).astype(np.uint8)
    assert silhouettes(frames, NOISE).max() == 0
