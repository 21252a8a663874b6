"""Frames of two spheres from files that films are read from: grey, with all their bits."""

import json
from collections.abc import Callable
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
    stack = read_frames(colour_video(tmp_path, colours))
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


def photron(folder: Path, _colours: np.ndarray) -> Path:
    shape = cameras.FRAMES, cameras.ROWS, cameras.COLUMNS
    return cameras.write_photron(folder / "0001", np.full(shape, 700, np.uint16), 10)


def cine(folder: Path, _colours: np.ndarray) -> Path:
    shape = cameras.FRAMES, cameras.ROWS, cameras.COLUMNS
    return cameras.write_cine(folder / "0001.cine", np.full(shape, 700, np.uint16))


def colour_tiff(folder: Path, colours: np.ndarray) -> Path:
    tifffile.imwrite(folder / "0001.tiff", colours, photometric="rgb", metadata=None)
    return folder / "0001.tiff"


def colour_array(folder: Path, colours: np.ndarray) -> Path:
    np.save(folder / "0001.npy", colours)
    return folder / "0001.npy"


def colour_video(folder: Path, colours: np.ndarray) -> Path:
    path = folder / "0001.avi"
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"FFV1"), 30.0, (COLUMNS, ROWS))
    for frame in colours:
        video.write(frame)
    video.release()
    return path


def folder_of_png(folder: Path, colours: np.ndarray) -> Path:
    made = folder / "0001"
    made.mkdir()
    for k, frame in enumerate(colours):
        cv2.imwrite(str(made / f"{k}.png"), frame[..., 0])
    return made


@pytest.mark.parametrize(
    "write", [photron, cine, colour_tiff, colour_array, colour_video, folder_of_png]
)
def test_times_beside_the_frames_go_before_all_others(
    write: Callable[[Path, np.ndarray], Path], colours: np.ndarray, tmp_path: Path
) -> None:
    path = write(tmp_path, colours)
    beside = tmp_path / "0001.json"
    beside.write_text(json.dumps({"times_s": [7.0, 7.25, 8.0]}))
    np.testing.assert_array_equal(read_frames(path).times_s, [0.0, 0.25, 1.0])
    beside.write_text(json.dumps({"times_s": [7.0, 7.25]}))
    with pytest.raises(InputError, match="2 times for 3 frames"):
        read_frames(path)


def test_without_them_the_times_of_a_phantom_and_the_rate_of_a_photron_are_taken(
    colours: np.ndarray, tmp_path: Path
) -> None:
    # Their headers: 500 and 2000 frames/s.
    assert read_frames(cine(tmp_path, colours)).times_s == pytest.approx([0, 2e-3, 4e-3])
    assert read_frames(photron(tmp_path, colours)).times_s == pytest.approx([0, 5e-4, 1e-3])


def test_an_array_in_colour_has_red_first(tmp_path: Path) -> None:
    red = np.zeros((COUNT, ROWS, COLUMNS, 3), np.uint8)
    red[..., 0] = 200
    path = colour_array(tmp_path, red)
    np.testing.assert_allclose(read_frames(path).light, 0.299 * 200, atol=0.01)


def test_raw_pictures_that_hold_red_green_and_blue_have_red_first(tmp_path: Path) -> None:
    (tmp_path / "0001").mkdir()
    red = np.zeros((ROWS, COLUMNS, 3), np.uint8)
    red[..., 0] = 200
    tifffile.imwrite(tmp_path / "0001" / "0.dng", red, photometric="rgb", metadata=None)
    np.testing.assert_allclose(read_frames(tmp_path / "0001").light, 0.299 * 200, atol=0.01)


@pytest.mark.parametrize(("largest", "bits"), [(200, 8), (850, 10)])
def test_colour_of_16_bits_says_which_bits_were_taken_however_dark(
    largest: int, bits: int, tmp_path: Path
) -> None:
    dark = np.full((COUNT, ROWS, COLUMNS, 3), 100, np.uint16)
    # The brightness of the brightest pixel stays below 256 in either film.
    dark[0, 0, 0] = largest, 0, 0
    stack = read_frames(colour_array(tmp_path, dark))
    (note,) = [note for note in stack.notes if "bits" in note]
    assert f"values of up to {largest} are taken for those of {bits} bits" in note
    np.testing.assert_allclose(stack.light[1], 100 * 255 / (2**bits - 1), rtol=1e-5)


def test_colour_of_8_bits_needs_no_word_on_its_depth(colours: np.ndarray, tmp_path: Path) -> None:
    notes = read_frames(colour_array(tmp_path, colours)).notes
    assert not any("bits" in note for note in notes)


def test_a_folder_of_raw_pictures_is_a_shot_s_frames(tmp_path: Path) -> None:
    grey = np.random.default_rng(5).integers(0, 4096, (8, 10), dtype=np.uint16)
    grey[0, 0] = 4095
    folder = raws.folder_of(tmp_path, raws.dng(grey, raws.GREY), raws.dng(grey // 2, raws.GREY))
    stack = read_frames(folder)
    np.testing.assert_allclose(stack.light[0], grey * (255 / 4095), rtol=1e-6)


def test_a_place_without_frames_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_frames(tmp_path / "0001.cine")
