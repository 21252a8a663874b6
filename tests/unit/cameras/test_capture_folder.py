"""A stack of the capture folder is read whole or refused with file, place, found and expected."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rigctl.cameras.capture_folder import StackNote, read_stack
from rigctl.errors import FramesError

RATE = 1000.0
NOISE = np.random.default_rng(7).integers(0, 256, (6, 12, 10), dtype=np.uint8)


def write(folder: Path, pixels: Any = NOISE, **changes: Any) -> Path:
    """Write a stack of pictures 812 to 817 without 814, changed as told."""
    note = {
        "frames": 6, "rows": 12, "columns": 10, "frame_rate_hz": RATE,
        "sequence": [812, 813, 815, 816, 817, 818],
        "times_s": [0.812, 0.813, 0.815, 0.816, 0.817, 0.818],
        "lost": [814],
    }  # fmt: skip
    tifffile.imwrite(folder / "x.tiff", pixels, photometric="minisblack", metadata=None)
    path = folder / "x.json"
    path.write_text(json.dumps(note | changes))
    return path


def test_pictures_come_with_number_time_and_what_was_lost(tmp_path: Path) -> None:
    frames = read_stack(write(tmp_path), picture_rate_hz=RATE)
    np.testing.assert_array_equal(frames.pixels, NOISE)
    assert frames.sequence.tolist() == [812, 813, 815, 816, 817, 818]
    assert frames.times_s.tolist() == [0.812, 0.813, 0.815, 0.816, 0.817, 0.818]
    assert frames.lost == (814,)
    assert frames.source.endswith("x.tiff")


LIES: dict[str, tuple[dict[str, Any], str]] = {
    "more frames than pages": (
        {"frames": 7, "sequence": [*range(812, 819)], "times_s": [n / 1e3 for n in range(7)]},
        r"6 pages, allowed 7 frames",
    ),
    "another size": ({"rows": 13}, r"page 0 of \(12, 10\) uint8, allowed \(13, 10\)"),
    "count of numbers": ({"sequence": [812]}, r"1 entries in sequence, allowed frames = 6"),
    "count of times": ({"times_s": [0.8]}, r"1 entries in times_s"),
    "another rate": ({"frame_rate_hz": 500.0}, r"500 pictures/s, allowed 1000 pictures/s"),
    "times that do not fit the numbers": (
        {"times_s": [0.812, 0.813, 0.814, 0.816, 0.817, 0.818]},
        r"frame 2 0\.001000 s after the one before, allowed 2 pictures apart",
    ),
    "a number as text": ({"rows": "12"}, r"rows"),
    "a truth value for a number": ({"frames": True}, r"frames"),
    "an unknown field": ({"colour": 1}, r"colour"),
    "no rate at all": ({"frame_rate_hz": 0.0}, r"frame_rate_hz"),
    "not a number": ({"frame_rate_hz": float("nan")}, r"frame_rate_hz|the file"),
}  # fmt: skip


@pytest.mark.parametrize(("changes", "found"), LIES.values(), ids=LIES)
def test_a_description_that_lies_is_refused(
    tmp_path: Path, changes: dict[str, Any], found: str
) -> None:
    path = write(tmp_path, **changes)
    with pytest.raises(FramesError, match=found) as caught:
        read_stack(path, picture_rate_hz=RATE)
    assert str(path.with_suffix("")) in str(caught.value)


@pytest.mark.parametrize(
    "pixels",
    [NOISE.astype(np.uint16), NOISE[:, :, :9], np.stack([NOISE] * 3, axis=-1)[:6]],
    ids=["16 bit", "a column short", "colour"],
)
def test_pages_of_another_depth_or_size_are_refused(tmp_path: Path, pixels: Any) -> None:
    path = write(tmp_path)
    kind = "rgb" if pixels.ndim == 4 else "minisblack"
    tifffile.imwrite(tmp_path / "x.tiff", pixels, photometric=kind, metadata=None)
    with pytest.raises(FramesError, match=r"page 0 of"):
        read_stack(path, picture_rate_hz=RATE)


@pytest.mark.parametrize("part", range(10))
def test_a_truncated_stack_is_refused_unless_every_pixel_is_still_there(
    tmp_path: Path, part: int
) -> None:
    path = write(tmp_path)
    tiff = path.with_suffix(".tiff")
    whole = tiff.read_bytes()
    refused = 0
    for size in range(len(whole) * part // 10, len(whole) * (part + 1) // 10, 3):
        tiff.write_bytes(whole[:size])
        try:
            frames = read_stack(path, picture_rate_hz=RATE)
        except FramesError as error:
            refused += "x.tiff" in str(error)
        else:
            np.testing.assert_array_equal(frames.pixels, NOISE)
    assert refused > 0


def test_an_absent_stack_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path)
    path.with_suffix(".tiff").unlink()
    with pytest.raises(FramesError, match="cannot be read"):
        read_stack(path, picture_rate_hz=RATE)


@given(st.binary(max_size=200))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_no_bytes_in_place_of_the_description_raise_anything_but_a_frames_error(
    tmp_path: Path, data: bytes
) -> None:
    path = write(tmp_path)
    path.write_bytes(data)
    with pytest.raises(FramesError):
        read_stack(path, picture_rate_hz=RATE)


@given(st.binary(max_size=400))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_no_bytes_in_place_of_the_stack_raise_anything_but_a_frames_error(
    tmp_path: Path, data: bytes
) -> None:
    path = write(tmp_path)
    path.with_suffix(".tiff").write_bytes(data)
    with pytest.raises(FramesError):
        read_stack(path, picture_rate_hz=RATE)


@given(st.binary(max_size=40), st.integers(0, 900))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_no_damage_inside_the_stack_raises_anything_but_a_frames_error(
    tmp_path: Path, data: bytes, place: int
) -> None:
    path = write(tmp_path)
    tiff = path.with_suffix(".tiff")
    whole = tiff.read_bytes()
    tiff.write_bytes(whole[:place] + data + whole[place + len(data) :])
    try:
        frames = read_stack(path, picture_rate_hz=RATE)
    except FramesError:
        return
    assert frames.pixels.shape == NOISE.shape


def test_a_page_with_two_heights_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path)
    with tifffile.TiffFile(path.with_suffix(".tiff"), mode="r+") as tiff:
        height = tiff.pages.first.tags[257]
        tiff.filehandle.seek(height.offset + 2)
        tiff.filehandle.write(struct.pack("<HIHH", 3, 2, 12, 12))
    with pytest.raises(FramesError, match="damaged"):
        read_stack(path, picture_rate_hz=RATE)


@pytest.mark.parametrize("tag", [256, 257, 277])
def test_a_page_whose_size_was_damaged_is_refused_before_it_claims_memory(
    tmp_path: Path, tag: int
) -> None:
    path = write(tmp_path)
    with tifffile.TiffFile(path.with_suffix(".tiff"), mode="r+") as tiff:
        tiff.pages.first.tags[tag].overwrite(60_000)
    with pytest.raises(FramesError, match=r"page 0|damaged"):
        read_stack(path, picture_rate_hz=RATE)


def test_the_example_of_the_reference_page_is_a_valid_description() -> None:
    page = Path(__file__).parents[3] / "docs" / "reference" / "wire-protocols.md"
    example = page.read_text().split("```json\n")[1].split("```")[0]
    note = StackNote.model_validate_json(example)
    assert (note.rows, note.columns, note.lost) == (192, 240, (814,))
