"""What every recording must satisfy before a shot may use it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rigctl.cameras.frames import FrameSequence
from rigctl.errors import FramesError


@dataclass(frozen=True, slots=True)
class Expected:
    """The frames that were asked for: numbers `first` to `first` + `count` - 1, and their size.

    `still` says that a frame may equal the one before it: codecs hold a picture in which nothing
    moves to the bit.
    """

    first: int
    count: int
    rows: int
    columns: int
    still: bool = False


def check_frames(frames: FrameSequence, expected: Expected) -> None:
    """See that a recording is the one that was asked for.

    Frames that the source itself reports as lost pass: they stay named in `FrameSequence.lost`.

    Raises
    ------
    FramesError
        Size, depth, order, count or times are wrong; a frame is missing that is not reported
        lost; or a frame equals the one before it in every pixel, which no sensor's noise allows
        (a codec does: `Expected.still`).
    """
    _check_shape(frames, expected)
    _check_order(frames)
    _check_numbers(frames, expected)
    if not expected.still:
        _check_alive(frames)


def _check_shape(frames: FrameSequence, expected: Expected) -> None:
    count = len(frames.sequence)
    wanted = (count, expected.rows, expected.columns)
    if frames.pixels.dtype != np.uint8 or frames.pixels.shape != wanted:
        raise FramesError(
            "the frames have another size or depth",
            part=frames.source,
            value=f"{frames.pixels.shape} of {frames.pixels.dtype}",
            limit=f"{wanted} of uint8 (frames, rows, columns)",
            todo="compare the camera's format with rows and columns in the configuration",
        )
    if len(frames.times_s) != count:
        raise FramesError(
            "frames and times differ in number",
            part=frames.source,
            value=f"{len(frames.times_s)} times",
            limit=f"{count} frames",
            todo="check the frame source",
        )


def _check_order(frames: FrameSequence) -> None:
    for what, values in (("number", frames.sequence), ("time", frames.times_s)):
        wrong = np.flatnonzero(~(np.diff(values) > 0))
        if wrong.size:
            place = int(wrong[0]) + 1
            raise FramesError(
                f"the {what} of frame {place} of the stack does not follow the one before it",
                part=frames.source,
                value=f"{values[place]}",
                limit=f"above {values[place - 1]}",
                todo="a frame was repeated or exchanged: check the frame source",
            )
    if not np.all(np.isfinite(frames.times_s)):
        raise FramesError("a frame has no finite time", part=frames.source, todo="check the source")


def _check_numbers(frames: FrameSequence, expected: Expected) -> None:
    wanted = set(range(expected.first, expected.first + expected.count))
    there, lost = {int(number) for number in frames.sequence}, set(frames.lost)
    if there | lost == wanted and not there & lost:
        return
    missing, extra = sorted(wanted - there - lost), sorted((there | lost) - wanted)
    found = f"{len(there)} frames, {len(lost)} reported lost"
    for word, numbers in (
        ("missing without a word", missing),
        ("not asked for", extra),
        ("both there and lost", sorted(there & lost)),
    ):
        if numbers:
            found += f", {word}: {_few(numbers)}"
    raise FramesError(
        "the frames are not those that were asked for",
        part=frames.source,
        value=found,
        limit=f"{expected.count} frames from number {expected.first}",
        todo="check the frame source, then fire again",
    )


def _check_alive(frames: FrameSequence) -> None:
    for place in range(1, len(frames.pixels)):
        if np.array_equal(frames.pixels[place - 1], frames.pixels[place]):
            raise FramesError(
                f"frame {place} of the stack equals the one before it in every pixel",
                part=frames.source,
                value=f"frame number {frames.sequence[place]}",
                limit="frames that differ at least by the sensor's noise",
                todo="the picture is frozen or repeated: check camera, lens cap and digitiser",
            )


def _few(numbers: list[int]) -> str:
    shown = ", ".join(map(str, numbers[:5]))
    return shown if len(numbers) <= 5 else f"{shown} and {len(numbers) - 5} more"
