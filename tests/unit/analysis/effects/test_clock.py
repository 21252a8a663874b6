"""When a frame shows what: offsets of the exposure and blocks that are read one after another."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.effects.clock import block_readout, exposure_offset, frame_rate
from analysis.effects.effect import ClockEffect, Effect, Exposure
from analysis.model.fitting.fit import fit_campaign
from analysis.model.predict.prediction import predict
from analysis.setup import CameraSetup
from tests.unit.analysis.model.hard_spheres import campaign

SCALE = 1574.8
CAMERA = CameraSetup(1000.0, 192, 240, (88, 192), (0, 88), SCALE, (132.0, 120.0), (46.0, 120.0))
TIMES = np.array([[0.0, 1e-3, 2e-3], [0.0, 1e-3, 2e-3]])


def exposure(rows: tuple[float, float]) -> Exposure:
    """Spheres a and b whose centres stand in the given rows of the front view throughout."""
    position = np.zeros((2, 3, 2, 3))
    position[..., 0] = (np.array(rows) - 132.0) / SCALE
    return Exposure(TIMES, position)


def shown(
    effect: Effect, rows: tuple[float, float], value: float, camera: CameraSetup = CAMERA
) -> tuple[np.ndarray, np.ndarray]:
    """True times of X, Y, Z, shape (2, 3, 2, 3), and of orientations, (2, 3, 2)."""
    assert isinstance(effect, ClockEffect)
    place, turn = effect.expose(exposure(rows), camera, np.array([value]))
    return np.broadcast_to(place, (2, 3, 2, 3)), np.broadcast_to(turn, (2, 3, 2))


def test_positions_are_later_than_orientations_by_the_offset() -> None:
    place, turn = shown(exposure_offset.EFFECT, (130, 140), 2e-5)
    np.testing.assert_allclose(place - TIMES[..., None, None], 2e-5, rtol=1e-9)
    np.testing.assert_array_equal(turn - TIMES[..., None], 0.0)


def test_a_frame_rate_too_low_by_a_share_stretches_all_times_alike() -> None:
    place, turn = shown(frame_rate.EFFECT, (130, 140), 0.01)
    np.testing.assert_allclose(place[0, :, 0, 0], [0.0, 1.01e-3, 2.02e-3])
    np.testing.assert_array_equal(place, np.repeat(turn[..., None], 3, axis=3))


def test_the_next_lower_block_is_read_83_microseconds_later() -> None:
    place, _ = shown(block_readout.EFFECT, (120, 136), 1.0)
    np.testing.assert_allclose(place[:, :, 1, :2] - place[:, :, 0, :2], 83.3e-6, rtol=1e-3)


def test_the_whole_frame_takes_the_frame_time_to_read() -> None:
    place, _ = shown(block_readout.EFFECT, (0, 192), 1.0)
    np.testing.assert_allclose(place[:, :, 1, :2] - place[:, :, 0, :2], 1e-3)
    fast = replace(CAMERA, frame_rate_hz=4000.0)
    place, _ = shown(block_readout.EFFECT, (0, 192), 0.5, fast)
    np.testing.assert_allclose(place[:, :, 1, :2] - place[:, :, 0, :2], 0.125e-3)


def test_the_middle_row_is_exposed_when_the_frame_says() -> None:
    place, _ = shown(block_readout.EFFECT, (95.5, 95.5), 1.0)
    np.testing.assert_allclose(place[..., :2] - TIMES[..., None, None], 0.0, atol=1e-15)


def test_depth_is_read_in_the_mirror_and_the_orientation_in_both_views() -> None:
    # The mirror shows Z = 0 in row 46, 86 rows above row 132: 86 / 192 of a frame time earlier.
    place, turn = shown(block_readout.EFFECT, (132, 132), 1.0)
    np.testing.assert_allclose(place[..., 2] - place[..., 1], -86e-3 / 192, rtol=1e-9)
    np.testing.assert_allclose(turn, (place[..., 0] + place[..., 2]) / 2, rtol=1e-9, atol=1e-15)


def test_without_a_mirror_all_is_read_in_the_front_view() -> None:
    single = replace(CAMERA, top_view_rows=None, top_origin_px=None)
    place, turn = shown(block_readout.EFFECT, (120, 150), 1.0, single)
    np.testing.assert_allclose(place, np.repeat(turn[..., None], 3, axis=3), atol=1e-18)


@pytest.mark.parametrize("steps", [1, 5, 11])
def test_the_mean_slope_follows_the_staircase_of_blocks(steps: int) -> None:
    # Averaged over the sides of an outline of 40 rows (weights as they hold the column of the
    # centre: sin^2), blocks of 16 rows differ from their mean slope by less than 0.5 rows.
    angle = np.linspace(0, np.pi, 20001)
    centre = 60.0 + steps
    rows = np.floor((centre + 20 * np.cos(angle) + 0.5) / 16)
    staircase = np.average(rows * 16 + 7.5, weights=np.sin(angle) ** 2)
    place, _ = shown(block_readout.EFFECT, (centre, 95.5), 1.0)
    delay = (place[0, 0, 0, 1] - place[0, 0, 1, 1]) * 192 / 1e-3
    assert delay == pytest.approx(staircase - 95.5, abs=0.5)


def test_without_a_scale_no_row_is_known_and_none_is_delayed() -> None:
    unscaled = replace(CAMERA, scale_px_per_m=None)
    place, turn = shown(block_readout.EFFECT, (0, 192), 1.0, unscaled)
    np.testing.assert_array_equal(place - TIMES[..., None, None], 0.0)
    np.testing.assert_array_equal(turn - TIMES[..., None], 0.0)


@pytest.mark.parametrize(
    ("row", "block"), [(0.0, 0), (15.4, 0), (15.6, 1), (95.4, 5), (95.6, 6), (191.0, 11)]
)
def test_a_pose_dated_by_its_block_has_the_time_of_the_blocks_middle(
    row: float, block: int
) -> None:
    (variant,) = block_readout.EFFECT.variants
    place, _ = shown(variant, (row, 7.5), 1.0)
    late = place[:, :, 0, :2] - place[:, :, 1, :2]
    np.testing.assert_allclose(late, block * 1e-3 / 12, atol=1e-12)


@pytest.mark.parametrize("sphere", [0, 1])
def test_each_sphere_is_predicted_at_the_time_of_its_own_rows_in_each_view(sphere: int) -> None:
    data = campaign(4, seed=2)
    fit = fit_campaign(data)
    theory = fit.theory.with_effect(block_readout.EFFECT)
    read = predict(data, fit.states, theory.at(np.append(fit.theory.vector, 1.0))).position
    # The row of the apparent place says when it was read; there the sphere must have been then.
    front, top = 132 + SCALE * read[..., 0], 46 - SCALE * read[..., 2]
    for axis, row in enumerate((front, front, top)):
        delayed = replace(data, times_s=data.times_s + (row[:, :, sphere] - 95.5) * 1e-3 / 192)
        expected = predict(delayed, fit.states, fit.theory).position
        np.testing.assert_allclose(
            read[:, :, sphere, axis], expected[:, :, sphere, axis], atol=1e-6
        )
