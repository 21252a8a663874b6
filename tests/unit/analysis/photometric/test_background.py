"""The background and the noise behind discs that move."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.photometric.render.background import background_of, first_background

SHAPE, FRAMES = (60, 80), 16


def filmed(noise, scene, seed=0):
    """A bright disc crosses the scene from left to right; frames and discs."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    discs = np.array([[[30.0, 5.0 * k, 10.0]] for k in range(FRAMES)])
    frames = np.tile(scene, (FRAMES, 1, 1)) + noise * rng.normal(size=(FRAMES, *SHAPE))
    for frame, ((row, column, radius),) in zip(frames, discs, strict=True):
        frame[np.hypot(y - row, x - column) < radius] = 180
    return np.clip(np.rint(frames), 0, 255).astype(np.uint8), discs


def sloping():
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return 30.0 + 0.1 * x + 0.05 * y


@pytest.mark.parametrize("noise", [1.0, 2.0, 4.0])
def test_noise_is_that_of_the_pixels_with_its_rounding(noise):
    frames, discs = filmed(noise, sloping())
    assert background_of(frames, discs)[1] == pytest.approx(np.hypot(noise, 12**-0.5), rel=0.03)


def test_a_smooth_scene_is_known_better_than_the_mean_of_its_frames():
    frames, discs = filmed(2.0, sloping())
    error = background_of(frames, discs)[0] - sloping()
    assert np.sqrt((error**2).mean()) < 0.5 * 2.0 / np.sqrt(FRAMES)


def test_a_rough_scene_is_taken_as_it_is():
    rough = sloping() + 20.0 * (np.indices(SHAPE).sum(axis=0) % 7 == 0)
    frames, discs = filmed(1.0, rough)
    error = background_of(frames, discs)[0] - rough
    assert np.sqrt((error**2).mean()) < 0.5


def test_the_first_background_stands_still_while_the_disc_passes():
    frames, _ = filmed(1.0, sloping())
    assert np.abs(first_background(frames) - sloping()).max() < 6.0
