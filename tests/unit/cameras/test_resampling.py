"""A grabber's frames in the recorder's size: where things lie, and how bright they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from rigctl.cameras.build import build_capture
from rigctl.cameras.playback import Crop, ResampledVideo
from rigctl.cameras.v4l2 import VideoFrame
from rigctl.config import V4l2Source, load
from rigctl.config.camera import EktaproCamera
from rigctl.errors import ConfigurationError

CONFIG = Path(__file__).parents[3] / "config"
GRABBERS = [
    (480, 640, Crop(0, 0, 480, 640)),
    (576, 720, Crop(0, 0, 576, 720)),
    (576, 720, Crop(28, 40, 520, 640)),
]


class Grabber:
    """Gives one frame again and again."""

    name = "grabber"

    def __init__(self, pixels: NDArray[np.uint8]) -> None:
        self.pixels, self.streams, self.closed = pixels, False, False

    def check(self) -> None:
        pass

    def start(self) -> None:
        self.streams = True

    def read(self, timeout_s: float) -> VideoFrame:
        assert self.streams
        assert timeout_s > 0.0
        return VideoFrame(self.pixels, 17, 2.5, (16,))

    def stop(self) -> None:
        self.streams = False

    def close(self) -> None:
        self.closed = True


def resampled(pixels: NDArray[np.uint8], crop: Crop) -> VideoFrame:
    video = ResampledVideo(Grabber(pixels), crop, 192, 240)
    video.start()
    return video.read(1.0)


@pytest.mark.parametrize(("rows", "columns", "crop"), GRABBERS)
def test_a_disc_lies_where_the_stated_scale_says(rows: int, columns: int, crop: Crop) -> None:
    at = (crop.top + 0.4 * crop.rows, crop.left + 0.7 * crop.columns)
    row, column = np.indices((rows, columns))
    down, across = crop.rows / 192, crop.columns / 240
    far = np.hypot((row - at[0]) / down, (column - at[1]) / across)
    frame = resampled((200.0 * (far < 15.0)).astype(np.uint8), crop)
    assert frame.pixels.shape == (192, 240)
    weight = frame.pixels.astype(float)
    seen_row, seen_column = np.indices(weight.shape)
    found = [(weight * where).sum() / weight.sum() for where in (seen_row, seen_column)]
    expected = [
        (at[0] - crop.top + 0.5) / down - 0.5,
        (at[1] - crop.left + 0.5) / across - 0.5,
    ]
    np.testing.assert_allclose(found, expected, atol=0.05)
    assert weight.sum() / 200.0 == pytest.approx(np.pi * 15.0**2, rel=0.01)


def test_what_lies_outside_the_picture_is_left_out() -> None:
    pixels = np.full((576, 720), 255, np.uint8)
    pixels[28:548, 40:680] = 30
    assert (resampled(pixels, Crop(28, 40, 520, 640)).pixels == 30).all()


def test_number_time_and_lost_frames_are_the_grabbers() -> None:
    frame = resampled(np.zeros((480, 640), np.uint8), Crop(0, 0, 480, 640))
    assert (frame.number, frame.time_s, frame.lost) == (17, 2.5, (16,))


def test_the_scale_stands_in_the_name_that_the_manifest_keeps() -> None:
    video = ResampledVideo(Grabber(np.zeros((480, 640), np.uint8)), Crop(0, 0, 480, 640), 192, 240)
    assert video.scale == (2.5, pytest.approx(2.6667, abs=1e-4))
    assert "2.5 rows and 2.667 columns to one" in video.name


def section(**grabber: object) -> EktaproCamera:
    camera = load(CONFIG / "simulated.toml").camera
    assert isinstance(camera, EktaproCamera)
    source = V4l2Source.model_validate({"driver": "v4l2", "device": "/dev/video9", **grabber})
    return camera.model_copy(update={"source": source})


@pytest.mark.parametrize(
    ("grabber", "said"),
    [
        ({"frame_rows": 480}, "together"),
        ({"crop": (0, 0, 192, 240)}, "together"),
        ({"frame_rows": 480, "frame_columns": 640, "crop": (0, 10, 480, 640)}, "480 x 640"),
    ],
)
def test_a_crop_that_cannot_be_is_refused(grabber: dict[str, object], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        section(**grabber)


def test_a_configured_grabber_of_another_size_needs_no_laboratory_to_be_refused() -> None:
    with pytest.raises(ConfigurationError, match="simulated"):
        build_capture(section(frame_rows=480, frame_columns=640), None)
