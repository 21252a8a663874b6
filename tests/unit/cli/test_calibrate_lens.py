"""From a filmed board to a ball filmed through the same lens."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from rigctl import cli
from tests.unit.analysis.balls.boards import TrueLens, chessboard, filmed
from tests.unit.cli.falling_ball import DIAMETER_MM, RADIUS, SHAPE, answer, bouncing, picture

LENS = TrueLens(SHAPE[0], SHAPE[1], 200.0, (118.0, 57.0), -0.3, 0.0)


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("board")
    for view in range(10):
        grey = filmed(LENS, chessboard(3, 5), 0.01, view)
        cv2.imwrite(str(folder / f"{view}.png"), grey)
    return folder


@pytest.fixture(scope="module")
def bounces(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A ball that falls before the camera, seen through the lens."""
    folder = tmp_path_factory.mktemp("ball")
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    x, y = LENS.rays(rows, columns)
    straight = LENS.centre[1] + LENS.focal * x, LENS.centre[0] + LENS.focal * y
    places = [place.astype(np.float32) for place in straight]
    for k, row in enumerate(bouncing()):
        bent = cv2.remap(
            picture(row), places[0], places[1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
        )
        cv2.imwrite(str(folder / f"{k:04d}.png"), bent)
    return folder


@pytest.mark.long
def test_a_filmed_board_gives_the_lens_that_sets_the_size_of_a_ball_right(
    board: Path, bounces: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lens = tmp_path / "lens.toml"
    of_board = ["calibrate", str(board), "--board", "3x5", "--square-mm", "10"]
    assert cli.run([*of_board, "--out", str(lens), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["lens"]["k1"] == pytest.approx(LENS.k1, abs=4 * found["lens"]["k1_sigma"])
    size = ["--ball-diameter-mm", f"{DIAMETER_MM:.3f}", "--fps", "200", "--exposure-us", "0"]
    bent = answer(capsys, str(bounces), *size)
    straight = answer(capsys, str(bounces), *size, "--lens", str(lens))
    wide, narrow = (shot["ball"]["diameter_px"]["value"] for shot in (straight, bent))
    assert wide == pytest.approx(2 * RADIUS, rel=0.015)
    # The surest discs lie near the middle, where the lens bends least.
    assert narrow < 0.99 * wide
    e = straight["impacts"][0]["e"]
    assert e["value"] == pytest.approx(0.8, abs=max(4 * e["sigma"], 0.005))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--board", "9by6", "--square-mm", "20"], "as in 9x6"),
        (["--board", "9x6"], "--square-mm: is missing"),
        (["--board", "9x6", "--square-mm", "20", "--marker-mm", "25"], "not smaller than a square"),
        (["--square-mm", "20"], "state the board too"),
        (["--board", "9x6", "--square-mm", "20"], "seen in 0 different views of 10 pictures"),
    ],
)
def test_options_that_make_no_board_are_refused_with_what_to_do(
    options: list[str], words: str, board: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["calibrate", str(board), *options]) != 0
    assert words in " ".join(capsys.readouterr().err.split())
