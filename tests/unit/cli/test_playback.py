"""A film of a tape's playback at the command line, from the grabber's frames to a shot."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import tifffile

from rigctl import cli
from simulators.ektapro.grabber import Wrong
from tests.playbacks import COLUMNS, ROWS, Digitised, digitised

WRONG = Wrong(frozenset({9, 31}), frozenset({8}))


@pytest.fixture
def film() -> Digitised:
    return digitised("pal", wrong=WRONG)


@pytest.fixture
def path(film: Digitised, tmp_path: Path) -> Path:
    np.save(tmp_path / "playback.npy", np.stack(film.frames))
    return tmp_path / "playback.npy"


def asked(path: Path, *more: str) -> list[str]:
    out = path.with_name("0001.tiff")
    return [
        *("playback", str(path), "--out", str(out), "--recorded-per-s", "1000"),
        *("--film-per-s", "25", "--scan", "top-first", "--size", f"{ROWS}x{COLUMNS}", *more),
    ]


def test_each_picture_is_written_once_with_its_number_and_its_time_on_the_tape(
    film: Digitised, path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shown = sorted({number + 812 for pair in film.truth for number in pair})
    assert cli.run(asked(path, "--first", "812", "--json")) == 0
    document = json.loads(capsys.readouterr().out)
    note = json.loads(path.with_name("0001.json").read_text())
    assert document["pictures"] == note["sequence"] == shown
    assert note["times_s"] == pytest.approx([number / 1000 for number in shown])
    assert note["lost"] == sorted(set(range(shown[0], shown[-1])) - set(shown))
    assert tifffile.imread(path.with_name("0001.tiff")).shape == (len(shown), ROWS, COLUMNS)


def test_what_cannot_be_numbered_says_so_and_what_would_help(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save(tmp_path / "still.npy", np.stack(digitised("ntsc", moving=False).frames))
    assert cli.run(asked(tmp_path / "still.npy")) == 0
    said = capsys.readouterr().out
    assert "perhaps picture" in said
    assert "--counted" in said


@pytest.mark.parametrize(
    ("more", "word"),
    [
        (("--crop", "0,0,600,10"), "--crop"),
        (("--counted", "3:4"), "--counted"),
        (("--size", "192"), "--size"),
    ],
)
def test_an_option_that_is_not_of_its_form_is_named(
    path: Path, more: tuple[str, ...], word: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(asked(path, *more)) == cli.BAD_INPUT
    assert word in capsys.readouterr().err
