"""Files of frames that were cut: none is taken for a shorter one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import tifffile

from analysis.errors import InputError
from analysis.imaging.files.stack import read_stack
from tests.unit.analysis.imaging.test_stack import FRAMES, avi, tiff


@pytest.mark.parametrize("kept", [1, 3])
def test_a_truncated_tiff_names_its_first_broken_frame(tmp_path: Path, kept: int) -> None:
    path = tmp_path / "0001.tiff"
    with tifffile.TiffWriter(path) as writer:
        for frame in FRAMES:
            writer.write(frame, photometric="minisblack", metadata=None, contiguous=False)
    with tifffile.TiffFile(path) as whole:
        end = whole.pages[kept].dataoffsets[0] + 100  # type: ignore[union-attr]
    path.write_bytes(path.read_bytes()[:end])
    with pytest.raises(
        InputError, match=rf"truncated in frame {kept}: its data end at byte"
    ) as fault:
        read_stack(path)
    assert fault.value.path == str(path)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.7, 0.9, 0.99])
def test_a_tiff_cut_anywhere_is_never_taken_for_a_shorter_one(tmp_path: Path, share: float) -> None:
    path = tiff(tmp_path / "0001.tiff", np.repeat(FRAMES, 4, axis=0))
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(InputError, match=r"frame|damaged") as fault:
        read_stack(path)
    assert fault.value.path == str(path)


@pytest.mark.parametrize("kept", range(1, 5))
def test_a_tiff_that_ends_between_two_frames_is_truncated(tmp_path: Path, kept: int) -> None:
    path = tmp_path / "0001.tiff"
    with tifffile.TiffWriter(path) as writer:
        for frame in FRAMES:
            writer.write(frame, photometric="minisblack", metadata=None, contiguous=False)
    with tifffile.TiffFile(path) as whole:
        following = whole.pages[kept].offset
    path.write_bytes(path.read_bytes()[:following])
    with pytest.raises(InputError, match=f"truncated after frame {kept - 1}"):
        read_stack(path)


def behind_one_page(path: Path, frames: np.ndarray, **form: object) -> Path:
    """Write frames one after another behind a single page, as ImageJ does beyond 4 GB."""
    tifffile.imwrite(path, frames, photometric="minisblack", **form)
    with tifffile.TiffFile(path) as whole:
        page = whole.pages.first
        pointer, end = page.offset + 2 + 12 * len(page.tags), page.dataoffsets[0] + frames.nbytes
    content = bytearray(path.read_bytes()[:end])
    content[pointer : pointer + 4] = bytes(4)
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("form", [{"imagej": True}, {"metadata": {}}])
def test_frames_behind_a_single_page_are_all_read(tmp_path: Path, form: dict[str, object]) -> None:
    path = behind_one_page(tmp_path / "0001.tiff", FRAMES, **form)
    np.testing.assert_array_equal(read_stack(path).pixels, FRAMES)


@pytest.mark.parametrize("form", [{"imagej": True}, {"metadata": {}}])
@pytest.mark.parametrize("lost", [1, FRAMES[0].size, 2 * FRAMES[0].size + 10])
def test_a_cut_among_frames_behind_a_single_page_names_the_frame(
    tmp_path: Path, form: dict[str, object], lost: int
) -> None:
    path = behind_one_page(tmp_path / "0001.tiff", FRAMES, **form)
    path.write_bytes(path.read_bytes()[:-lost])
    first_cut = len(FRAMES) - 1 - (lost - 1) // FRAMES[0].size
    with pytest.raises(InputError, match=f"truncated in frame {first_cut}"):
        read_stack(path)


@pytest.mark.parametrize("form", [{}, {"imagej": True}, {"ome": True}, {"bigtiff": True}])
def test_a_described_tiff_cut_anywhere_is_never_taken_for_a_shorter_one(
    tmp_path: Path, form: dict[str, object]
) -> None:
    path = tmp_path / "0001.tiff"
    tifffile.imwrite(path, FRAMES, photometric="minisblack", **form)
    whole = path.read_bytes()
    assert read_stack(path).pixels.shape == FRAMES.shape
    for cut in range(1, len(whole) - 8, 97):
        path.write_bytes(whole[:cut])
        with pytest.raises(InputError, match=r"truncated|damaged"):
            read_stack(path)


def test_a_tiff_with_fewer_pages_than_its_description_counts_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "0001.tiff"
    tifffile.imwrite(path, FRAMES, photometric="minisblack", compression="zlib")
    with tifffile.TiffFile(path) as whole:
        page = whole.pages[2]
        pointer = page.offset + 2 + 12 * len(page.tags)  # type: ignore[union-attr]
    content = bytearray(path.read_bytes())
    content[pointer : pointer + 4] = bytes(4)
    path.write_bytes(content)
    with pytest.raises(InputError, match="after frame 2: its description counts 5 frames"):
        read_stack(path)


@pytest.mark.parametrize("name", ["0001.avi", "0001.mkv", "0001.mp4"])
def test_a_video_cut_anywhere_is_never_taken_for_a_shorter_one(tmp_path: Path, name: str) -> None:
    path = avi(tmp_path / name)
    assert read_stack(path).pixels.shape == FRAMES.shape
    whole = path.read_bytes()
    for share in (0.1, 0.3, 0.5, 0.7, 0.9, 0.95, 0.99, 1.0):
        path.write_bytes(whole[: min(int(share * len(whole)), len(whole) - 1)])
        with pytest.raises(InputError, match=r"truncated|no decoder"):
            read_stack(path)


def test_a_video_with_fewer_frames_than_its_container_counts_is_refused(tmp_path: Path) -> None:
    path = avi(tmp_path / "0001.avi")
    content = bytearray(path.read_bytes())
    # dwTotalFrames of the main header, dwLength of the stream's (AVI RIFF file reference).
    for name, offset in ((b"avih", 24), (b"strh", 40)):
        place = content.index(name) + offset
        assert int.from_bytes(content[place : place + 4], "little") == len(FRAMES)
        content[place : place + 4] = (9).to_bytes(4, "little")
    path.write_bytes(content)
    with pytest.raises(InputError, match="5 frames can be read, the container counts 9"):
        read_stack(path)


def test_a_video_that_counts_no_frames_is_read_with_a_note(tmp_path: Path) -> None:
    path = avi(tmp_path / "0001.mkv")
    content = path.read_bytes()
    # Matroska: Duration becomes Void of the same length.
    duration = b"\x44\x89\x88"
    assert content.count(duration) == 1
    path.write_bytes(content.replace(duration, b"\xec\x89\x00"))
    stack = read_stack(path)
    assert stack.pixels.shape == FRAMES.shape
    assert "does not say how many frames" in stack.notes[0]
    assert read_stack(avi(tmp_path / "0002.mkv")).notes == ()
