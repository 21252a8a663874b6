import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from rigctl import cli

PLACES = [(40.0, 45.0, 15.0), (60.0, 110.0, 20.0)]


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    image = np.full((100, 160), 40, np.uint8)
    for row, column, radius in PLACES:
        cv2.circle(image, (int(column), int(row)), int(radius), 180, -1, cv2.LINE_AA)
    path = tmp_path / "two.png"
    cv2.imwrite(str(path), cv2.GaussianBlur(image, (0, 0), 1.0))
    return path


def test_the_discs_of_a_picture_are_printed_as_one_document(
    picture: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["find-discs", str(picture), "--diameter-px", "20:50", "--json"]) == 0
    discs = sorted(json.loads(capsys.readouterr().out)["discs"], key=lambda disc: disc["row"])
    for disc, (row, column, radius) in zip(discs, PLACES, strict=True):
        assert (disc["row"], disc["column"]) == pytest.approx((row, column), abs=0.3)
        assert disc["radius"] == pytest.approx(radius, abs=1.0)


def test_a_person_gets_a_table_with_errors(
    picture: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["find-discs", str(picture), "--diameter-px", "20:50"]) == 0
    assert "2 discs" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("diameters", "words"),
    [("20", "colon"), ("a:b", "colon"), ("50:20", "the smaller first"), ("2:30", "6 px")],
)
def test_a_range_that_cannot_be_is_bad_input(
    picture: Path, diameters: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["find-discs", str(picture), "--diameter-px", diameters]) == cli.BAD_INPUT
    said = capsys.readouterr().err
    assert "--diameter-px" in said
    assert words in said


def test_a_file_that_is_absent_or_no_picture_is_bad_input(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = tmp_path / "text.png"
    text.write_text("no picture")
    (tmp_path / "empty.png").write_bytes(b"")
    for name, words in (
        ("text.png", "not a whole PNG file"),
        ("empty.png", "not a whole PNG file"),
        ("x", "cannot be read"),
    ):
        code = cli.run(["find-discs", str(tmp_path / name), "--diameter-px", "20:50"])
        assert code == cli.BAD_INPUT
        assert words in capsys.readouterr().err
