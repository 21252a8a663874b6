"""A lens is found from pictures of a board, held against the lens that drew them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from analysis.balls.films.reading import open_film
from analysis.balls.lens.board import Board
from analysis.balls.lens.calibration import LensCalibration, calibrate_lens
from analysis.balls.lens.lens import Lens, StraightFilm, read_lens, write_lens
from analysis.errors import InputError
from tests.unit.analysis.balls.boards import TrueLens, charuco, chessboard, filmed

SQUARE_M, VIEWS = 0.02, 14
LENS = TrueLens()
BOARD = Board(7, 5, SQUARE_M)


def write_views(folder: Path, texture: np.ndarray, views: range = range(VIEWS)) -> Path:
    folder.mkdir()
    for view in views:
        cv2.imwrite(str(folder / f"{view:03d}.png"), filmed(LENS, texture, SQUARE_M, view))
    return folder


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_views(tmp_path_factory.mktemp("lens") / "chessboard", chessboard(7, 5))


@pytest.fixture(scope="module")
def calibrated(pictures: Path) -> LensCalibration:
    return calibrate_lens(pictures, BOARD)


def assert_is_the_true_lens(lens: Lens) -> None:
    for found in lens.focal_px:
        assert abs(found - LENS.focal) < 4 * lens.focal_sigma_px
        assert found == pytest.approx(LENS.focal, rel=5e-3)
    assert lens.centre_px == pytest.approx(LENS.centre, abs=2.0)
    assert abs(lens.k1 - LENS.k1) < 4 * lens.k1_sigma < 0.15
    corner = np.hypot(*(np.array([0.0, 0.0]) - LENS.centre)) / LENS.focal
    shift = LENS.focal * (LENS.k1 * corner**3 + LENS.k2 * corner**5)
    assert abs(lens.corner_px - shift) < max(4 * lens.corner_sigma_px, 0.3)


def test_a_chessboard_gives_the_lens_that_filmed_it(calibrated: LensCalibration) -> None:
    assert_is_the_true_lens(calibrated.lens)
    assert calibrated.rms_px < 0.15


@pytest.mark.parametrize(
    "kind",
    [cv2.aruco.DICT_4X4_50, pytest.param(cv2.aruco.DICT_6X6_250, marks=pytest.mark.long)],
)
def test_a_charuco_board_gives_it_too_whatever_its_markers(tmp_path: Path, kind: int) -> None:
    folder = write_views(tmp_path / "charuco", charuco(7, 5, kind), range(0, VIEWS, 2))
    found = calibrate_lens(folder, replace(BOARD, marker_m=0.7 * SQUARE_M))
    assert_is_the_true_lens(found.lens)


def test_straight_edges_are_straight_in_a_film_without_distortion(
    pictures: Path, calibrated: LensCalibration
) -> None:
    film = open_film(pictures)
    bent, straight = (
        np.mean([_bend(picture[..., 0]) for picture in either.pictures()])
        for either in (film, StraightFilm(film, calibrated.lens))
    )
    assert StraightFilm(film, calibrated.lens).head.principal == calibrated.lens.centre_px
    assert bent > 4 * straight
    assert straight < 0.04


def _bend(grey: np.ndarray) -> float:
    """Return the rms distance of a board's corners from lines through their rows, px."""
    found, corners = cv2.findChessboardCornersSB(np.ascontiguousarray(grey), (7, 5))
    if not found:
        return np.nan
    rows = corners.reshape(5, 7, 2).astype(float)
    centred = rows - rows.mean(axis=1, keepdims=True)
    return float(np.sqrt((np.linalg.svd(centred)[1][:, 1] ** 2).mean() / 7))


def test_a_lens_is_read_as_it_was_written(tmp_path: Path, calibrated: LensCalibration) -> None:
    write_lens(tmp_path / "lens.toml", calibrated.lens)
    assert read_lens(tmp_path / "lens.toml") == calibrated.lens


def test_a_lens_with_a_fault_is_refused_by_its_key(
    tmp_path: Path, calibrated: LensCalibration
) -> None:
    path = tmp_path / "lens.toml"
    write_lens(path, calibrated.lens)
    path.write_text(path.read_text().replace("height_px", "hight_px"))
    with pytest.raises(InputError, match="hight_px"):
        read_lens(path)


def test_a_board_that_is_seen_too_seldom_is_refused_with_what_to_do(
    tmp_path: Path, pictures: Path
) -> None:
    folder = tmp_path / "few"
    folder.mkdir()
    for picture in sorted(pictures.iterdir())[:3]:
        (folder / picture.name).write_bytes(picture.read_bytes())
    with pytest.raises(InputError, match=r"3 different views of 3 pictures; 5 are needed"):
        calibrate_lens(folder, BOARD)
    with pytest.raises(InputError, match=r"8 x 5 inner corners is seen in 0 different views"):
        calibrate_lens(folder, replace(BOARD, columns=8))


def test_a_film_of_another_size_is_refused(pictures: Path, calibrated: LensCalibration) -> None:
    with pytest.raises(InputError, match=r"400 x 300 pixels; .* with 800 x 600"):
        StraightFilm(open_film(pictures), replace(calibrated.lens, height_px=600, width_px=800))
