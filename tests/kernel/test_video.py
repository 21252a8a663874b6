"""Frames through a real kernel's Video4Linux2 (vivid): to the bit, counted, refused by name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.kernel
Stories = dict[str, list[dict[str, Any]]]
BARS = 8
"""Columns of the test picture, from white to black."""


@pytest.fixture(scope="module")
def video(guest: Callable[[Path], Stories]) -> Stories:
    stories = guest(Path(__file__).with_name("video_guest.py"))
    if "halted" in stories:
        pytest.skip(f"this machine is too busy for an emulated camera: {stories['halted']}")
    return stories


def test_every_picture_comes_through_to_the_bit(video: Stories) -> None:
    [found] = video["loop back"]
    assert found["exact"] >= 15
    # Whole, or not there at all: no picture has a wrong pixel.
    assert found["alike"] < 0.5


def test_every_number_between_two_frames_is_named_as_lost(video: Stories) -> None:
    for story in ("reader asleep", "damaged frames", "dropped frames"):
        [found] = video[story]
        passed = range(found["before"] + 1, found["numbers"][-1] + 1)
        assert set(found["lost"]) == set(passed) - set(found["numbers"]), story
    assert video["reader asleep"][0]["lost"]
    assert len(video["damaged frames"][0]["lost"]) >= 3
    assert len(video["dropped frames"][0]["lost"]) >= 5


def test_time_stamps_rise(video: Stories) -> None:
    assert video["loop back"][0]["rises"]


def test_each_format_shows_the_same_grey_bars(video: Stories) -> None:
    bars = {found["name"]: found["bars"] for found in video["format"]}
    assert bars.keys() == {"GREY", "YUYV", "UYVY", "Y10", "Y12", "Y16"}
    for name, levels in bars.items():
        assert len(levels) == BARS
        # The bars of the test picture go from white through the colours to black.
        assert levels[0] > levels[1] > levels[6] > levels[7], name
        reference = bars["YUYV"] if name == "UYVY" else bars["GREY"]
        if name != "YUYV":
            assert levels == pytest.approx(reference, abs=1.5), name


def test_frames_of_640_x_480_and_720_x_576_become_pictures_of_the_recorder(video: Stories) -> None:
    assert [found["whole"] for found in video["cropped"]] == [[480, 640], [576, 720], [576, 720]]
    for found in video["cropped"]:
        assert found["picture"] == [192, 240]
        assert found["range"] > 50, "the test picture has bars"
        # Each pixel is the mean of the four or nine that it covers, rounded.
        assert found["off"] <= 0.51, found["name"]


@pytest.mark.parametrize(
    ("story", "error"),
    [
        ("other size", "FramesError"),
        ("two readers", "DeviceBusyError"),
        ("pulled out", "DeviceAbsentError"),
    ],
)
def test_what_the_kernel_refuses_has_its_name(video: Stories, story: str, error: str) -> None:
    assert video[story][0]["error"] == error
