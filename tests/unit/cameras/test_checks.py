"""A recording that is not the one asked for is refused; one that admits its losses passes."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigctl.cameras.checks import Expected, check_frames
from rigctl.cameras.frames import FrameSequence
from rigctl.errors import FramesError

EXPECTED = Expected(first=10, count=5, rows=4, columns=3)


def recorded(numbers: list[int], lost: tuple[int, ...] = ()) -> FrameSequence:
    """Frames that differ, at 1000 a second."""
    sequence = np.array(numbers, dtype=np.int64)
    noise = np.random.default_rng(3).integers(0, 256, (len(numbers), 4, 3), dtype=np.uint8)
    return FrameSequence(noise, sequence / 1000.0, sequence, lost, "camera")


def test_all_that_was_asked_for_passes() -> None:
    check_frames(recorded([10, 11, 12, 13, 14]), EXPECTED)


def test_a_loss_that_the_source_reports_passes_and_stays_named() -> None:
    frames = recorded([10, 11, 13, 14], lost=(12,))
    check_frames(frames, EXPECTED)
    assert frames.lost == (12,)


@given(st.lists(st.sampled_from(range(10, 15)), min_size=1, max_size=5, unique=True).map(sorted))
def test_every_frame_is_there_or_reported_lost_or_the_recording_is_refused(
    numbers: list[int],
) -> None:
    gone = tuple(sorted(set(range(10, 15)) - set(numbers)))
    check_frames(recorded(numbers, gone), EXPECTED)
    if gone:
        with pytest.raises(FramesError, match=f"missing without a word: {gone[0]}"):
            check_frames(recorded(numbers, gone[1:]), EXPECTED)


REFUSED: dict[str, tuple[Callable[[], FrameSequence], str]] = {
    "a frame too many": (lambda: recorded([10, 11, 12, 13, 14, 15]), "not asked for: 15"),
    "lost and there": (
        lambda: recorded([10, 11, 12, 13, 14], lost=(12,)),
        "both there and lost: 12",
    ),
    "a number twice": (lambda: recorded([10, 11, 11, 12, 13]), "the number of frame 2"),
    "numbers going back": (lambda: recorded([10, 12, 11, 13, 14]), "the number of frame 2"),
    "no frames": (lambda: recorded([]), "0 frames"),
    "another size": (
        lambda: dataclasses.replace(
            recorded([10]), pixels=np.zeros((1, 3, 4), dtype=np.uint8)
        ),
        r"\(1, 3, 4\)",
    ),
    "another depth": (
        lambda: dataclasses.replace(
            recorded([10]), pixels=np.zeros((1, 4, 3), dtype=np.uint16)  # type: ignore[arg-type]
        ),
        "uint16",
    ),
    "times standing still": (
        lambda: dataclasses.replace(recorded([10, 11, 12, 13, 14]), times_s=np.zeros(5)),
        "the time of frame 1",
    ),
    "times without end": (
        lambda: dataclasses.replace(
            recorded([10, 11, 12, 13, 14]), times_s=np.array([0, 1, 2, 3, np.inf])
        ),
        "finite",
    ),
    "times of another count": (
        lambda: dataclasses.replace(recorded([10, 11]), times_s=np.zeros(1)),
        "1 times",
    ),
    "a frozen picture": (
        lambda: dataclasses.replace(
            recorded([10, 11, 12, 13, 14]), pixels=np.full((5, 4, 3), 7, dtype=np.uint8)
        ),
        "equals the one before it in every pixel",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("made", "found"), REFUSED.values(), ids=REFUSED)
def test_what_is_wrong_is_named(made: Callable[[], FrameSequence], found: str) -> None:
    with pytest.raises(FramesError, match=found) as caught:
        check_frames(made(), EXPECTED)
    assert str(caught.value).startswith("camera: ")
