"""Raw pictures (.dng), written here tag by tag as the TIFF and DNG specifications say."""

from __future__ import annotations

import struct
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from analysis.balls.films.reading import open_film
from analysis.errors import InputError

Values = NDArray[np.uint16]
ROWS, COLUMNS = 20, 28
SHORT, LONG, BYTE = 3, 4, 1
MOSAIC, GREY = 32803, 1


def dng(
    values: Values,
    kind: int,
    pattern: tuple[int, ...] = (),
    preview: bool = False,
    code: int = 1,
    exposure: tuple[int, int] | None = None,
    rate: tuple[int, int] | None = None,
) -> bytes:
    """Return a file of one directory and one strip of 16 bits, and two fractions behind it."""
    content = values.astype("<u2").tobytes()
    rows, columns = values.shape
    tags = [
        (254, LONG, 1, int(preview)),
        (256, LONG, 1, columns),
        (257, LONG, 1, rows),
        (258, SHORT, 1, 16),
        (259, SHORT, 1, code),
        (262, SHORT, 1, kind),
        (273, LONG, 1, 8),
        (277, SHORT, 1, 1),
        (278, LONG, 1, rows),
        (279, LONG, 1, len(content)),
    ]
    if pattern:
        tags.append((33421, SHORT, 2, 2 | 2 << 16))
        tags.append((33422, BYTE, 4, int.from_bytes(bytes(pattern), "little")))
    end = 8 + len(content)
    fractions = b""
    for number, kind_of_number, fraction in ((33434, 5, exposure), (51044, 10, rate)):
        if fraction is not None:
            tags.append((number, kind_of_number, 1, end + len(fractions)))
            fractions += struct.pack("<II", *fraction)
    directory = struct.pack("<H", len(tags))
    for tag in tags:
        directory += struct.pack("<HHII", *tag)
    head = struct.pack("<2sHI", b"II", 42, end + len(fractions))
    return head + content + fractions + directory + struct.pack("<I", 0)


def folder_of(tmp_path: Path, *files: bytes) -> Path:
    folder = tmp_path / "film"
    folder.mkdir()
    for k, content in enumerate(files):
        (folder / f"frame_{k:06d}.dng").write_bytes(content)
    return folder


def ramps() -> NDArray[np.float64]:
    """Return red, green and blue that change evenly: means of neighbours are exact."""
    row, column = np.mgrid[:ROWS, :COLUMNS]
    return np.stack([1000 + 40 * row, 3000 + 20 * column, 9000 - 60 * row + 20 * column], axis=2)


@pytest.mark.parametrize("pattern", [(0, 1, 1, 2), (1, 0, 2, 1), (1, 2, 0, 1), (2, 1, 1, 0)])
def test_a_mosaic_of_colours_is_filled_in(pattern: tuple[int, ...], tmp_path: Path) -> None:
    whole = ramps()
    row, column = np.mgrid[:ROWS, :COLUMNS]
    colour = np.array(pattern)[2 * (row % 2) + column % 2]
    mosaic = np.take_along_axis(whole, colour[..., None], axis=2)[..., 0].astype(np.uint16)
    film = open_film(
        folder_of(tmp_path, dng(mosaic, MOSAIC, pattern), dng(mosaic, MOSAIC, pattern))
    )
    assert (film.head.frames, film.head.channels, film.head.encoded) == (2, 3, False)
    picture = next(iter(film.pictures()))
    inner = (slice(2, -2), slice(2, -2))
    blue_first = whole[..., ::-1][inner]
    assert np.abs(picture[inner].astype(np.float64) - blue_first).max() <= 1.0


def test_a_grey_raw_picture_is_what_the_sensor_saw(tmp_path: Path) -> None:
    values = np.random.default_rng(0).integers(0, 4096, (ROWS, COLUMNS)).astype(np.uint16)
    film = open_film(folder_of(tmp_path, dng(values, GREY)))
    assert np.array_equal(next(iter(film.pictures()))[..., 0], values)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (dng(np.ones((ROWS, COLUMNS), np.uint16), GREY, preview=True), "preview"),
        (dng(np.ones((ROWS, COLUMNS), np.uint16), MOSAIC, (0, 1, 1, 3)), "mosaics of 2 x 2"),
        (dng(np.ones((ROWS, COLUMNS), np.uint16), MOSAIC), "mosaics of 2 x 2"),
        (dng(np.ones((ROWS, COLUMNS), np.uint16), GREY, code=7), "JPEG"),
        (dng(np.ones((2, 2), np.uint16), MOSAIC, (0, 1, 1, 2)), "4 x 4"),
    ],
)
def test_a_raw_picture_that_is_not_read_is_refused_by_name(
    content: bytes, words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        open_film(folder_of(tmp_path, content))


@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    places=st.lists(st.tuples(st.integers(0, 1300), st.integers(0, 255)), min_size=1, max_size=6),
    keep=st.integers(0, 1400),
)
def test_a_damaged_raw_picture_is_read_or_refused(
    places: list[tuple[int, int]], keep: int, tmp_path: Path
) -> None:
    content = bytearray(dng(np.ones((ROWS, COLUMNS), np.uint16), MOSAIC, (0, 1, 1, 2)))
    for place, value in places:
        content[place % len(content)] = value
    folder = tmp_path / "film"
    folder.mkdir(exist_ok=True)
    (folder / "0.dng").write_bytes(bytes(content[:keep] if keep < len(content) else content))
    # Anything but a refusal fails.
    with suppress(InputError):
        film = open_film(folder)
        for picture in film.pictures():
            assert picture.shape == (film.head.height, film.head.width, film.head.channels)


def test_the_exposure_comes_from_the_tags_and_the_rate_of_the_player_does_not(
    tmp_path: Path,
) -> None:
    grey = np.full((ROWS, COLUMNS), 900, dtype=np.uint16)
    film = open_film(folder_of(tmp_path, dng(grey, GREY, exposure=(1, 2000), rate=(24, 1))))
    assert film.head.exposure_s == pytest.approx(0.0005)
    assert film.head.rate_hz is None


@pytest.mark.parametrize("exposure", [None, (0, 1), (1, 0)])
def test_a_picture_that_states_no_exposure_has_none(
    exposure: tuple[int, int] | None, tmp_path: Path
) -> None:
    grey = np.full((ROWS, COLUMNS), 900, dtype=np.uint16)
    head = open_film(folder_of(tmp_path, dng(grey, GREY, exposure=exposure))).head
    assert head.exposure_s is None
