"""Films of cameras, written here byte by byte as their makers describe them."""

from __future__ import annotations

import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.balls.films.part import Cut, PartOfFilm
from analysis.balls.films.raw import RawLayout
from analysis.balls.films.reading import open_film
from analysis.errors import InputError

FRAMES, ROWS, COLUMNS = 3, 12, 16


@pytest.fixture
def values() -> NDArray[np.uint16]:
    rng = np.random.default_rng(1)
    return rng.integers(0, 1024, (FRAMES, ROWS, COLUMNS)).astype(np.uint16)


def packed(frame: NDArray[np.uint16], bits: int) -> bytes:
    text = "".join(f"{int(v):0{bits}b}" for v in frame.ravel())
    text += "0" * (-len(text) % 8)
    return int(text, 2).to_bytes(len(text) // 8, "big")


def write_photron(path: Path, values: NDArray[np.uint16], bits: int) -> Path:
    path.with_suffix(".cih").write_text(
        "#Camera Information Header\nRecord Rate(fps) : 2000\nShutter Speed(s) : 1/20000\n"
        f"Total Frame : {FRAMES}\nImage Width : {COLUMNS}\nImage Height : {ROWS}\n"
        f"Color Bit : {bits}\n"
    )
    content = b"".join(packed(frame, bits) for frame in values)
    if bits == 16:
        content = values.astype("<u2").tobytes()
    path.with_suffix(".mraw").write_bytes(content)
    return path.with_suffix(".mraw")


@pytest.mark.parametrize("bits", [10, 12, 16])
def test_frames_of_photron_are_those_that_were_packed(
    bits: int, values: NDArray[np.uint16], tmp_path: Path
) -> None:
    film = open_film(write_photron(tmp_path / "shot", values, bits))
    assert np.array_equal(np.stack(list(film.pictures()))[..., 0], values)
    assert (film.head.rate_hz, film.head.exposure_s) == (2000.0, 5e-5)


def test_a_short_file_of_photron_is_refused_with_what_it_holds(
    values: NDArray[np.uint16], tmp_path: Path
) -> None:
    path = write_photron(tmp_path / "shot", values, 12)
    path.write_bytes(path.read_bytes()[:-10])
    with pytest.raises(InputError, match=r"2 whole frames .* counts 3"):
        open_film(path)


def test_frames_of_photron_without_a_header_ask_for_it(tmp_path: Path) -> None:
    (tmp_path / "shot.mraw").write_bytes(b"")
    with pytest.raises(InputError, match="cih"):
        open_film(tmp_path / "shot.mraw")


def write_cine(path: Path, values: NDArray[np.uint16]) -> Path:
    setup_length = 200
    bitmap_at, setup_at = 44, 84
    tags_at = setup_at + setup_length
    times = struct.pack(f"<{FRAMES}Q", *[(7 << 32) + k * (1 << 32) // 500 for k in range(FRAMES)])
    exposures = struct.pack(f"<{FRAMES}I", *[int(2**32 * 1e-4)] * FRAMES)
    tags = struct.pack("<IHH", 8 + len(times), 1002, 0) + times
    tags += struct.pack("<IHH", 8 + len(exposures), 1003, 0) + exposures
    offsets_at = tags_at + len(tags)
    header = struct.pack(
        "<2sHHHiIiIIIIII",
        *(b"CI", 44, 0, 1, 0, FRAMES, 0, FRAMES, bitmap_at, setup_at, offsets_at, 0, 0),
    )
    bitmap = struct.pack("<IiiHHIIiiII", 40, COLUMNS, ROWS, 1, 16, 0, 0, 0, 0, 0, 0)
    setup = bytearray(setup_length)
    setup[140:142], setup[142:144] = b"ST", struct.pack("<H", setup_length)
    first = offsets_at + 8 * FRAMES
    size = 8 + 2 * ROWS * COLUMNS
    places = struct.pack(f"<{FRAMES}q", *[first + k * size for k in range(FRAMES)])
    pictures = b"".join(
        struct.pack("<II", 8, size - 8) + frame[::-1].astype("<u2").tobytes() for frame in values
    )
    path.write_bytes(header + bitmap + bytes(setup) + tags + places + pictures)
    return path


def test_frames_and_times_of_a_phantom_are_those_that_were_written(
    values: NDArray[np.uint16], tmp_path: Path
) -> None:
    film = open_film(write_cine(tmp_path / "shot.cine", values))
    assert np.array_equal(np.stack(list(film.pictures()))[..., 0], values)
    assert film.head.times_s == pytest.approx([0.0, 0.002, 0.004], abs=1e-9)
    assert film.head.exposure_s == pytest.approx(1e-4, rel=1e-5)


@pytest.mark.parametrize("length", [0, 30, 100, 300, 900])
def test_a_film_of_a_phantom_that_is_cut_short_is_refused(
    length: int, values: NDArray[np.uint16], tmp_path: Path
) -> None:
    path = write_cine(tmp_path / "shot.cine", values)
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(InputError):
        list(open_film(path).pictures())


def test_a_part_of_a_film_is_looked_at_and_nothing_else(
    values: NDArray[np.uint16], tmp_path: Path
) -> None:
    np.save(tmp_path / "film.npy", values)
    part = PartOfFilm(open_film(tmp_path / "film.npy"), Cut(1, 3, (2, 1, 10, 9)))
    assert np.array_equal(np.stack(list(part.pictures()))[..., 0], values[1:3, 1:10, 2:12])


def test_a_film_is_turned_by_quarter_turns_with_what_its_shutter_reads(
    values: NDArray[np.uint16], tmp_path: Path
) -> None:
    np.save(tmp_path / "film.npy", values)
    turned = PartOfFilm(open_film(tmp_path / "film.npy"), Cut(), 1)
    picture = next(turned.pictures())[..., 0]
    assert (turned.head.height, turned.head.width) == (COLUMNS, ROWS)
    # What was the last column is the first row.
    assert np.array_equal(picture[0], values[0][:, -1])


def test_what_the_lens_looks_at_is_where_it_was_in_a_part_that_is_turned(tmp_path: Path) -> None:
    marked = np.zeros((1, 20, 30), np.uint8)
    marked[0, 9, 14] = 255
    np.save(tmp_path / "film.npy", marked)
    part = PartOfFilm(open_film(tmp_path / "film.npy"), Cut(0, 1, (8, 2, 12, 16)))
    for turns in range(4):
        turned = PartOfFilm(part, Cut(), turns)
        (row, column), (picture,) = turned.head.principal, turned.pictures()
        pixel = np.argwhere(picture[..., 0] == 255)[0]
        # The middle of 20 x 30 pixels is half a pixel beside the one that was marked.
        assert np.abs(pixel - (row, column)).tolist() == [0.5, 0.5]
        assert turned.head.whole == ((20, 30), (30, 20))[turns % 2]


def test_a_grey_video_has_one_channel_and_its_times(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 50.0, (64, 48))
    for k in range(5):
        video.write(np.full((48, 64, 3), 40 * k, np.uint8))
    video.release()
    film = open_film(path)
    assert (film.head.frames, film.head.channels, film.head.rate_hz) == (5, 1, 50.0)
    assert film.head.times_s == pytest.approx(np.arange(5) / 50.0)
    levels = [float(picture.mean()) for picture in film.pictures()]
    assert levels == pytest.approx([0, 40, 80, 120, 160], abs=3)


@pytest.mark.parametrize(
    ("name", "codec"),
    [("a.mts", "mpg2"), ("a.MPG", "MPG1"), ("a.wmv", "WMV2"), ("a.3gp", "mp4v"), ("a.gif", "")],
)
def test_camcorders_and_old_telephones_films_have_all_their_frames_and_times(
    name: str, codec: str, tmp_path: Path
) -> None:
    path, count = tmp_path / name, 9
    pictures = [np.full((48, 64, 3), 20 * k, np.uint8) for k in range(count)]
    if codec:
        video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), 25.0, (64, 48))
        for picture in pictures:
            video.write(picture)
        video.release()
    else:
        moving = cv2.Animation()
        moving.frames, moving.durations = pictures, [40] * count
        assert cv2.imwriteanimation(str(path), moving)
    film = open_film(path)
    assert (film.head.frames, film.head.notes) == (count, ())
    assert film.head.rate_hz == pytest.approx(25.0)
    if codec != "MPG1":  # The last of its frames has no time.
        assert film.head.times_s == pytest.approx(np.arange(count) / 25.0, abs=1e-3)
    levels = [float(picture.mean()) for picture in film.pictures()]
    assert levels == pytest.approx([20 * k for k in range(count)], abs=8)


def test_a_list_of_other_files_is_no_film_whatever_its_name(tmp_path: Path) -> None:
    path = tmp_path / "film.mts"
    path.write_text("#EXTM3U\n#EXTINF:1,\nother.ts\n" * 20)
    with pytest.raises(InputError, match="no decoder"):
        open_film(path)


def state_pixels(path: Path, across: int, down: int) -> None:
    """Write the sides of pixels into an MP4 file whose frames lie before its boxes.

    The box `pasp` ends the sample entry (ISO/IEC 14496-12, 12.1.4); each box about it grows.
    """
    data = bytearray(path.read_bytes())
    about = [b"moov", b"trak", b"mdia", b"minf", b"stbl", b"stsd", b"mp4v"]
    heads = [data.index(name, data.index(b"moov")) - 4 for name in about]
    lengths = [int.from_bytes(data[head : head + 4]) for head in heads]
    end = heads[-1] + lengths[-1]
    for head, length in zip(heads, lengths, strict=True):
        data[head : head + 4] = (length + 16).to_bytes(4)
    data[end:end] = struct.pack(">I4sII", 16, b"pasp", across, down)
    path.write_bytes(data)


def test_a_ball_that_a_file_states_to_be_squeezed_is_round_in_its_pictures(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 50.0, (96, 96))
    picture = np.zeros((96, 96, 3), np.uint8)
    cv2.ellipse(picture, (48, 48), (20, 30), 0, 0, 360, (255, 255, 255), -1)
    for _ in range(3):
        video.write(picture)
    video.release()
    state_pixels(path, 3, 2)
    film = open_film(path)
    assert (film.head.height, film.head.width) == (96, 144)
    assert "3 wide to 2 high" in film.head.notes[0]
    rows, columns = np.nonzero(next(iter(film.pictures()))[..., 0] > 127)
    assert np.ptp(columns) == pytest.approx(np.ptp(rows), abs=2)


def test_a_film_without_a_header_holds_the_pixels_that_a_chronos_packed(tmp_path: Path) -> None:
    path = tmp_path / "film.raw"
    # 0x123 and 0xabc, twice: two pictures of two pixels.
    path.write_bytes(bytes.fromhex("231cab" * 2))
    film = open_film(path, RawLayout.of("2x1x12"))
    assert [picture.ravel().tolist() for picture in film.pictures()] == [[0x123, 0xABC]] * 2
    path.write_bytes(np.arange(8, dtype="<u2").tobytes())
    pictures = list(open_film(path, RawLayout.of("4x1x16")).pictures())
    assert [picture.ravel().tolist() for picture in pictures] == [[0, 1, 2, 3], [4, 5, 6, 7]]


def test_a_mosaic_without_a_header_has_the_colours_that_are_stated(tmp_path: Path) -> None:
    path = tmp_path / "film.raw"
    mosaic = np.zeros((8, 8), "<u2")
    mosaic[1::2, 0::2] = 900
    path.write_bytes(mosaic.tobytes())
    (picture,) = open_film(path, RawLayout.of("8x8x16:GBRG")).pictures()
    # Red alone is lit: blue, green, red.
    assert picture[2:6, 2:6].max(axis=(0, 1)).tolist() == [0, 0, 900]


def test_a_film_without_a_header_asks_for_its_pictures_and_refuses_a_part_of_one(
    tmp_path: Path,
) -> None:
    path = tmp_path / "film.raw"
    path.write_bytes(bytes(100))
    with pytest.raises(InputError, match="state its pictures with --raw"):
        open_film(path)
    with pytest.raises(
        InputError, match="100 bytes are 4 pictures of 4 x 4 pixels of 12 bits and 4"
    ):
        open_film(path, RawLayout.of("4x4x12"))
    for said in ("4x4x10", "0x4x16", "3x3x12", "4x4x16:RRRR", "film"):
        with pytest.raises(ValueError, match=said):
            RawLayout.of(said)


def test_pictures_of_sixteen_bits_keep_their_numbers(
    values: NDArray[np.uint16], tmp_path: Path
) -> None:
    for k, frame in enumerate(values):
        cv2.imwrite(str(tmp_path / f"{k}.png"), frame)
    assert np.array_equal(np.stack(list(open_film(tmp_path).pictures()))[..., 0], values)


def test_a_file_of_another_kind_is_refused_by_what_is_read(tmp_path: Path) -> None:
    (tmp_path / "film.xyz").write_bytes(b"")
    with pytest.raises(InputError, match=r"\.cine"):
        open_film(tmp_path / "film.xyz")


@pytest.mark.parametrize("name", ["film.avi", "film.tif", "film.npy", "film.cine"])
def test_an_empty_file_is_called_empty(name: str, tmp_path: Path) -> None:
    (tmp_path / name).touch()
    with pytest.raises(InputError, match=f"{name}: is an empty file"):
        open_film(tmp_path / name)
