"""Frames of two spheres from files that films are read from: grey, with all their bits."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import tifffile

from analysis.balls.films.frames import read_frames
from analysis.errors import InputError
from tests.unit.analysis.balls import test_camera_files as cameras
from tests.unit.analysis.balls import test_raw_pictures as raws

COUNT, ROWS, COLUMNS = 3, 32, 48


@pytest.fixture
def colours() -> np.ndarray:
    """Blue, green and red of smooth frames: a codec that halves colours leaves them."""
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    frames = [[40 + 3 * rows + k, 60 + 2 * columns, 200 - rows - columns] for k in range(COUNT)]
    return np.moveaxis(np.array(frames), 1, 3).astype(np.uint8)


def brightness(colours: np.ndarray) -> np.ndarray:
    return 0.114 * colours[..., 0] + 0.587 * colours[..., 1] + 0.299 * colours[..., 2]


def test_colour_tiff_and_png_become_their_brightness(colours: np.ndarray, tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "0001.tiff", colours[..., ::-1], photometric="rgb", metadata=None)
    (tmp_path / "0002").mkdir()
    for k, frame in enumerate(colours):
        cv2.imwrite(str(tmp_path / "0002" / f"{k:04d}.png"), frame)
    for place in (tmp_path / "0001.tiff", tmp_path / "0002"):
        stack = read_frames(place)
        np.testing.assert_allclose(stack.light, brightness(colours), atol=0.01)
        assert np.array_equal(stack.pixels, np.rint(stack.light))
        assert any("colour" in note for note in stack.notes)


def test_a_colour_video_becomes_its_brightness(colours: np.ndarray, tmp_path: Path) -> None:
    path = tmp_path / "0001.avi"
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"FFV1"), 30.0, (COLUMNS, ROWS))
    for frame in colours:
        video.write(frame)
    video.release()
    stack = read_frames(path)
    np.testing.assert_allclose(stack.light, brightness(colours), atol=2.0)
    # A player's times are not those of a fast camera.
    assert stack.times_s is None


def test_grey_frames_are_those_of_the_file(colours: np.ndarray, tmp_path: Path) -> None:
    grey = colours[..., 0]
    np.save(tmp_path / "0001.npy", grey)
    stack = read_frames(tmp_path / "0001.npy")
    assert np.array_equal(stack.pixels, grey)
    assert stack.light is stack.pixels


def test_frames_of_a_camera_s_own_file_keep_all_bits(tmp_path: Path) -> None:
    shape = cameras.FRAMES, cameras.ROWS, cameras.COLUMNS
    values = np.random.default_rng(4).integers(0, 4096, shape, dtype=np.uint16)
    values[0, 0, 0] = 4095
    photron = read_frames(cameras.write_photron(tmp_path / "0001", values, 12))
    np.testing.assert_allclose(photron.light, values * (255 / 4095), rtol=1e-6)


def test_a_folder_of_raw_pictures_is_a_shot_s_frames(tmp_path: Path) -> None:
    grey = np.random.default_rng(5).integers(0, 4096, (8, 10), dtype=np.uint16)
    grey[0, 0] = 4095
    folder = raws.folder_of(tmp_path, raws.dng(grey, raws.GREY), raws.dng(grey // 2, raws.GREY))
    stack = read_frames(folder)
    np.testing.assert_allclose(stack.light[0], grey * (255 / 4095), rtol=1e-6)


def test_a_place_without_frames_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_frames(tmp_path / "0001.cine")
