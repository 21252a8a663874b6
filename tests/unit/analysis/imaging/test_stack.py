import json
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
import tifffile

from analysis.balls.films.reading import open_film
from analysis.errors import InputError
from analysis.imaging.files.stack import read_stack

FRAMES = np.random.default_rng(3).integers(0, 256, (5, 48, 64), dtype=np.uint8)


def tiff(path: Path, frames: np.ndarray = FRAMES) -> Path:
    tifffile.imwrite(path, frames, photometric="minisblack", metadata=None)
    return path


def npy(path: Path, frames: np.ndarray = FRAMES) -> Path:
    np.save(path, frames)
    return path


def pngs(folder: Path, frames: np.ndarray = FRAMES) -> Path:
    folder.mkdir()
    for k, frame in enumerate(frames):
        assert cv2.imwrite(str(folder / f"{k:03d}.png"), frame)
    return folder


def avi(path: Path, frames: np.ndarray = FRAMES, *, colour: bool = False) -> Path:
    size = (frames.shape[2], frames.shape[1])
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"FFV1"), 30.0, size, colour)
    assert video.isOpened()
    for frame in frames:
        video.write(frame)
    video.release()
    return path


@pytest.mark.parametrize(
    ("name", "write"),
    [("0001.tiff", tiff), ("0001.TIF", tiff), ("0001.npy", npy), ("0001", pngs)],
)
def test_frames_come_back_to_the_last_bit(tmp_path: Path, name: str, write: object) -> None:
    stack = read_stack(write(tmp_path / name))  # type: ignore[operator]
    np.testing.assert_array_equal(stack.pixels, FRAMES)
    assert stack.pixels.dtype == np.uint8
    assert stack.times_s is None


@pytest.mark.parametrize("colour", [False, True])
def test_a_lossless_video_comes_back_within_a_level(tmp_path: Path, colour: bool) -> None:
    frames = np.repeat(FRAMES[..., None], 3, axis=3) if colour else FRAMES
    stack = read_stack(avi(tmp_path / "0001.avi", frames, colour=colour))
    assert stack.pixels.shape == FRAMES.shape
    assert np.abs(stack.pixels.astype(int) - FRAMES).max() <= 1


def test_a_compressed_tiff_is_read_too(tmp_path: Path) -> None:
    path = tmp_path / "0001.tiff"
    tifffile.imwrite(path, FRAMES, photometric="minisblack", compression="zlib", metadata=None)
    np.testing.assert_array_equal(read_stack(path).pixels, FRAMES)


def test_a_tiff_in_a_compression_that_is_not_read_is_not_called_damaged(tmp_path: Path) -> None:
    path = tmp_path / "0001.tiff"
    assert cv2.imwritemulti(str(path), list(FRAMES), [cv2.IMWRITE_TIFF_COMPRESSION, 5])
    with pytest.raises(InputError, match=r"compressed as LZW; save it uncompressed"):
        read_stack(path)


def test_a_tiff_of_one_page_is_one_frame(tmp_path: Path) -> None:
    assert read_stack(tiff(tmp_path / "0001.tiff", FRAMES[0])).pixels.shape == (1, 48, 64)


@pytest.mark.parametrize(
    "names",
    [
        ["0", "1", "2", "10", "11"],
        ["x4", "x5", "x06", "x70", "x800"],
        ["run2_9", "run2_10", "run2_11", "run10_1", "run10_2"],
    ],
)
def test_pngs_are_read_in_the_order_of_the_numbers_in_their_names(
    tmp_path: Path, names: list[str]
) -> None:
    folder = pngs(tmp_path / "frames")
    for k in range(len(names)):
        (folder / f"{k:03d}.png").rename(folder / f"_{k}")
    for k, name in enumerate(names):
        (folder / f"_{k}").rename(folder / f"{name}.{'PNG' if k == 3 else 'png'}")
    np.testing.assert_array_equal(read_stack(folder).pixels, FRAMES)


@pytest.mark.parametrize(
    ("first", "second", "why"),
    [
        ("1", "01", "have the same numbers"),
        ("left_1", "right_2", "differ in more than their numbers"),
        ("before", "after", "differ in more than their numbers"),
        ("1", "1_2", "differ in more than their numbers"),
    ],
)
def test_pngs_whose_names_give_no_order_are_refused(
    tmp_path: Path, first: str, second: str, why: str
) -> None:
    folder = pngs(tmp_path / "frames", FRAMES[:2])
    (folder / "000.png").rename(folder / f"{first}.png")
    (folder / "001.png").rename(folder / f"{second}.png")
    with pytest.raises(InputError, match=why) as fault:
        read_stack(folder)
    assert f"{first}.png" in fault.value.reason
    assert f"{second}.png" in fault.value.reason


def test_libraries_write_no_lines_of_their_own_about_broken_files(tmp_path: Path) -> None:
    for path in (avi(tmp_path / "a.avi"), avi(tmp_path / "b.mkv"), tiff(tmp_path / "c.tiff")):
        whole = path.read_bytes()
        middle = len(whole) // 2
        path.write_bytes(whole[:middle] + bytes(500) + whole[middle + 500 :])
        path.with_stem("short").write_bytes(whole[: int(0.7 * len(whole))])
    (tmp_path / "none.avi").write_bytes(b"these are no frames at all")
    program = (
        "import sys\nfrom pathlib import Path\nfrom analysis.errors import InputError\n"
        "from analysis.imaging.files.stack import read_stack\n"
        "for path in sorted(Path(sys.argv[1]).iterdir()):\n"
        "    try:\n        read_stack(path)\n"
        "    except InputError as error:\n        print(error.path)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert done.stderr == ""
    for name in ("short.avi", "short.mkv", "short.tiff", "none.avi"):
        assert str(tmp_path / name) in done.stdout.splitlines()


@pytest.mark.parametrize("name", ["0001.tiff", "0001.npy", "0001.avi"])
def test_a_file_of_another_kind_is_refused_by_name(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(b"these are no frames at all")
    with pytest.raises(InputError) as fault:
        read_stack(path)
    assert fault.value.path == str(path)


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_a_truncated_npy_is_refused(tmp_path: Path, share: float) -> None:
    path = npy(tmp_path / "0001.npy")
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(InputError, match="not a whole NPY file"):
        read_stack(path)


def test_objects_in_an_npy_are_never_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "0001.npy"
    np.save(path, np.array([{"harm": 1}], dtype=object), allow_pickle=True)
    with pytest.raises(InputError, match="not a whole NPY file"):
        read_stack(path)


@pytest.mark.parametrize(
    ("frames", "found"),
    [
        (FRAMES.astype(np.int32), "int32"),
        (FRAMES[0], r"\(48, 64\)"),
        (np.repeat(FRAMES[..., None], 3, axis=3), r"\(5, 48, 64, 3\)"),
        (FRAMES.astype(np.float64), "float64"),
    ],
)
def test_frames_that_are_not_grey_of_8_to_16_bits_are_refused_with_what_they_are(
    tmp_path: Path, frames: np.ndarray, found: str
) -> None:
    with pytest.raises(InputError, match=rf"{found}.*grey frames"):
        read_stack(npy(tmp_path / "0001.npy", frames))


@pytest.mark.parametrize(("bits", "seen"), [(10, 10), (12, 12), (14, 14), (16, 16), (11, 12)])
def test_more_bits_are_grey_levels_of_eight_with_their_fractions(
    tmp_path: Path, bits: int, seen: int
) -> None:
    values = np.random.default_rng(bits).integers(0, 1 << bits, FRAMES.shape)
    values[0, 0, 0] = (1 << bits) - 1
    stack = read_stack(tiff(tmp_path / "0001.tiff", values.astype(np.uint16)))
    assert stack.light == pytest.approx(values * 255.0 / ((1 << seen) - 1), rel=1e-6)
    assert np.abs(stack.pixels - stack.light.astype(float)).max() <= 0.5
    assert f"{seen} bits" in " ".join(stack.notes)


def test_eight_bits_are_what_they_are(tmp_path: Path) -> None:
    stack = read_stack(tiff(tmp_path / "0001.tiff", FRAMES))
    assert stack.light is stack.pixels
    np.testing.assert_array_equal(stack.pixels, FRAMES)


def test_a_colour_tiff_and_colour_pngs_are_refused(tmp_path: Path) -> None:
    colour = np.repeat(FRAMES[..., None], 3, axis=3)
    path = tmp_path / "0001.tiff"
    tifffile.imwrite(path, colour, photometric="rgb", metadata=None)
    for place in (path, pngs(tmp_path / "frames", colour)):
        with pytest.raises(InputError, match="grey frames"):
            read_stack(place)


def test_a_video_in_colour_names_the_frame(tmp_path: Path) -> None:
    frames = np.repeat(FRAMES[..., None], 3, axis=3)
    frames[2, :, :, 0] = 255 - frames[2, :, :, 0]
    with pytest.raises(InputError, match="frame 2 is in colour"):
        read_stack(avi(tmp_path / "0001.avi", frames, colour=True))


def test_frames_of_different_sizes_name_the_first_that_differs(tmp_path: Path) -> None:
    folder = pngs(tmp_path / "frames")
    assert cv2.imwrite(str(folder / "003.png"), FRAMES[3, :40])
    with pytest.raises(InputError, match=r"frame 3 is uint8 of shape \(40, 64\)"):
        read_stack(folder)


def test_a_broken_png_is_named(tmp_path: Path) -> None:
    folder = pngs(tmp_path / "frames")
    (folder / "002.png").write_bytes(b"\x89PNG broken")
    with pytest.raises(InputError, match=r"002\.png: not a whole PNG"):
        read_stack(folder)
    # Alone it is named alike, and a whole one is no film.
    for read in (read_stack, open_film):
        with pytest.raises(InputError, match=r"002\.png: not a whole PNG"):
            read(folder / "002.png")
        with pytest.raises(InputError, match=r"001\.png: is one picture and no film"):
            read(folder / "001.png")


def test_nothing_an_empty_folder_and_an_unknown_kind_are_refused(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "0001.txt").write_text("frames")
    for name, reason in (
        ("absent.tiff", "no such file"),
        ("empty", "without PNG"),
        ("0001.txt", "frames are read from"),
    ):
        with pytest.raises(InputError, match=reason) as fault:
            read_stack(tmp_path / name)
        assert fault.value.path == str(tmp_path / name)


def test_recorded_times_beside_the_frames_are_counted_from_the_first(tmp_path: Path) -> None:
    path = tiff(tmp_path / "0001.tiff")
    times = [0.812, 0.813, 0.815, 0.816, 0.817]
    document = {"sequence": [812, 813, 815, 816, 817], "times_s": times, "lost": [814]}
    path.with_suffix(".json").write_text(json.dumps(document))
    stack = read_stack(path)
    assert stack.times_s == pytest.approx([0.0, 0.001, 0.003, 0.004, 0.005])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('{"times_s": [0.0, 0.001]}', "2 times for 5 frames"),
        ('{"times_s": ["soon", 1, 2, 3, 4]}', "does not hold times_s"),
        ('{"time": []}', "does not hold times_s"),
        ("[1, 2", "not JSON"),
    ],
)
def test_recorded_times_that_cannot_be_used_are_refused_and_not_passed_over(
    tmp_path: Path, text: str, reason: str
) -> None:
    path = tiff(tmp_path / "0001.tiff")
    path.with_suffix(".json").write_text(text)
    with pytest.raises(InputError, match=reason) as fault:
        read_stack(path)
    assert fault.value.path == str(path.with_suffix(".json"))
