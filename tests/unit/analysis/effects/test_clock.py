"""When a frame shows what: offsets of the exposure and blocks that are read one after another."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.effects import block_readout, exposure_offset, frame_rate
from analysis.effects.effect import ClockEffect, Exposure
from analysis.setup import CameraSetup

SCALE = 1574.8
CAMERA = CameraSetup(1000.0, 192, 240, (88, 192), (0, 88), SCALE, (132.0, 120.0), (46.0, 120.0))
TIMES = np.array([[0.0, 1e-3, 2e-3], [0.0, 1e-3, 2e-3]])


def exposure(rows: tuple[float, float]) -> Exposure:
    """Spheres a and b whose centres stand in the given rows of the front view throughout."""
    position = np.zeros((2, 3, 2, 3))
    position[..., 0] = (np.array(rows) - 132.0) / SCALE
    return Exposure(TIMES, position)


def test_positions_are_later_than_orientations_by_the_offset() -> None:
    place, turn = exposure_offset.EFFECT.expose(exposure((130, 140)), CAMERA, np.array([2e-5]))
    np.testing.assert_allclose(place - TIMES[..., None], 2e-5, rtol=1e-9)
    np.testing.assert_array_equal(turn - TIMES[..., None], 0.0)


def test_a_frame_rate_too_low_by_a_share_stretches_all_times_alike() -> None:
    place, turn = frame_rate.EFFECT.expose(exposure((130, 140)), CAMERA, np.array([0.01]))
    np.testing.assert_allclose(place[0, :, 0], [0.0, 1.01e-3, 2.02e-3])
    np.testing.assert_array_equal(place, turn)


def test_the_next_lower_block_is_read_83_microseconds_later() -> None:
    place, _ = block_readout.EFFECT.expose(exposure((120, 136)), CAMERA, np.array([1.0]))
    np.testing.assert_allclose(place[..., 1] - place[..., 0], 83.3e-6, rtol=1e-3)


def test_the_whole_frame_takes_the_frame_time_to_read() -> None:
    place, _ = block_readout.EFFECT.expose(exposure((0, 192)), CAMERA, np.array([1.0]))
    np.testing.assert_allclose(place[..., 1] - place[..., 0], 1e-3)
    fast = replace(CAMERA, frame_rate_hz=4000.0)
    place, _ = block_readout.EFFECT.expose(exposure((0, 192)), fast, np.array([0.5]))
    np.testing.assert_allclose(place[..., 1] - place[..., 0], 0.125e-3)


def test_the_middle_row_is_exposed_when_the_frame_says() -> None:
    place, turn = block_readout.EFFECT.expose(exposure((95.5, 95.5)), CAMERA, np.array([1.0]))
    np.testing.assert_allclose(place, TIMES[..., None].repeat(2, axis=2), atol=1e-15)
    np.testing.assert_array_equal(place, turn)


@pytest.mark.parametrize("steps", [1, 5, 11])
def test_the_mean_slope_follows_the_staircase_of_blocks(steps: int) -> None:
    # Averaged over the sides of an outline of 40 rows (weights as they hold the column of the
    # centre: sin^2), blocks of 16 rows differ from their mean slope by less than 0.5 rows.
    angle = np.linspace(0, np.pi, 20001)
    centre = 60.0 + steps
    rows = np.floor((centre + 20 * np.cos(angle) + 0.5) / 16)
    staircase = np.average(rows * 16 + 7.5, weights=np.sin(angle) ** 2)
    place, _ = block_readout.EFFECT.expose(exposure((centre, 95.5)), CAMERA, np.array([1.0]))
    delay = (place[0, 0, 0] - place[0, 0, 1]) * 192 / 1e-3
    assert delay == pytest.approx(staircase - 95.5, abs=0.5)


def test_without_a_scale_no_row_is_known_and_none_is_delayed() -> None:
    unscaled = replace(CAMERA, scale_px_per_m=None)
    for part in block_readout.EFFECT.expose(exposure((0, 192)), unscaled, np.array([1.0])):
        np.testing.assert_array_equal(part, TIMES[..., None].repeat(2, axis=2))


@pytest.mark.parametrize(
    ("row", "block"), [(0.0, 0), (15.4, 0), (15.6, 1), (95.4, 5), (95.6, 6), (191.0, 11)]
)
def test_a_pose_dated_by_its_block_has_the_time_of_the_blocks_middle(
    row: float, block: int
) -> None:
    (variant,) = block_readout.EFFECT.variants
    assert isinstance(variant, ClockEffect)
    place, _ = variant.expose(exposure((row, 7.5)), CAMERA, np.array([1.0]))
    np.testing.assert_allclose(place[..., 0] - place[..., 1], block * 1e-3 / 12, atol=1e-12)
