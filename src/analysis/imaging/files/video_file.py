"""Frames from a video file, every one that its container counts or none."""

from __future__ import annotations

import os
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.errors import InputError, counted
from analysis.files import FrameBudget

# Quiet (ffmpeg's -8), read at the decoder's first use: what it finds wrong comes back as a refusal.
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)


class ColourError(InputError):
    """Frames whose channels differ."""


GREY_TOLERANCE = 2
"""Codecs that store colour bring grey back to within this many levels between channels."""
UNCOUNTED = "the video does not say how many frames it holds; that all are there is not checked"


_SIDES = (cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FRAME_WIDTH)
_BOXES = {b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip"}
"""With which an MP4 or QuickTime file can begin."""
_BEGINNINGS = (b"RIFF", b"\x1a\x45\xdf\xa3", b"\x30\x26\xb2\x75\x8e\x66\xcf\x11")
_BEGINNINGS_UNCOUNTED = (b"\x00\x00\x01\xba", b"GIF87a", b"GIF89a")
"""Of AVI, Matroska and ASF; of MPEG program streams and GIF, which do not count their frames."""
_PACKET, _SYNC = 188, 0x47
"""Bytes of a packet of an MPEG transport stream, and the first of each; camcorders put the time,
4 bytes, before it (ISO/IEC 13818-1, 2.4.3.2)."""
MOST_CHUNKS = 100_000
"""Outermost chunks of a file; each is looked at."""


def read_video(
    path: Path, budget: FrameBudget
) -> tuple[list[NDArray[np.generic]], tuple[str, ...]]:
    """Return the frames of a video, and what about them could not be checked.

    Raises
    ------
    InputError
        No decoder opens it, it ends before its container says, fewer frames can be read than the
        container counts, a frame is in colour, or it is beyond the budget; with the frame.
    """
    video = open_video(path)
    try:
        count = video.get(cv2.CAP_PROP_FRAME_COUNT)
        sides = [int(video.get(side)) for side in _SIDES]
        pages: list[NDArray[np.generic]] = []
        while (page := _next(video, sides, budget)) is not None:
            pages.append(_grey(path, len(pages), page))
    except cv2.error as error:
        raise _no_decoder(path) from error
    finally:
        video.release()
    # A container without a count answers zero, or a negative number beyond all bounds.
    if not count > 0:
        return pages, (UNCOUNTED,)
    if len(pages) < round(count):
        raise InputError(
            path,
            f"truncated or damaged: {counted(len(pages), 'frame')} can be read, the container "
            f"counts {round(count)}",
        )
    return pages, ()


def open_video(path: Path) -> cv2.VideoCapture:
    """Open a video; the caller releases it.

    Raises
    ------
    InputError
        It is no container that is read here, ends before its container says, or has no decoder.
    """
    if not _is_container(path):
        raise _no_decoder(path)
    _require_whole(path)
    try:
        video = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    except cv2.error as error:
        raise _no_decoder(path) from error
    if not video.isOpened():
        video.release()
        raise _no_decoder(path)
    return video


def _next(
    video: cv2.VideoCapture, sides: list[int], budget: FrameBudget
) -> NDArray[np.generic] | None:
    """Return the next picture, None after the last; its size is claimed before it is unpacked."""
    if not video.grab():
        return None
    budget.claim(sides)
    whole, page = video.retrieve()
    return np.asarray(page) if whole else None


def _no_decoder(path: Path) -> InputError:
    return InputError(path, "no decoder here opens this video")


def _is_container(path: Path) -> bool:
    """Return whether a file begins as one of pictures does.

    The decoder would take any of its kinds, lists of other files among them.
    """
    head = _head(path)
    return head.startswith(_BEGINNINGS) or head[4:8] in _BOXES or _uncounted(head)


def counts_frames(path: Path) -> bool:
    """Return whether a video's container says how many frames it has, not only how long it is."""
    return not _uncounted(_head(path))


def _uncounted(head: bytes) -> bool:
    packets = any(
        len(head) > first + step and head[first] == head[first + step] == _SYNC
        for first, step in ((0, _PACKET), (4, _PACKET + 4))
    )
    return packets or head.startswith(_BEGINNINGS_UNCOUNTED)


def _head(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(2 * _PACKET)


def _grey(path: Path, index: int, page: NDArray[np.generic]) -> NDArray[np.generic]:
    if page.ndim == 2:
        return page
    channels = page.astype(np.int16)
    spread = int(np.ptp(channels, axis=2).max())
    if spread > GREY_TOLERANCE:
        raise ColourError(
            path, f"frame {index} is in colour: its channels differ by up to {spread} levels"
        )
    return page[:, :, 1].copy()


def _require_whole(path: Path) -> None:
    """Refuse a file that ends before its outermost chunks do.

    The last frame of such a file may decode, partly grey, and be counted as whole.
    """
    size = path.stat().st_size
    end = _stated_end(path, size)
    if end > size:
        raise InputError(path, f"truncated: its container ends at byte {end}, the file at {size}")


def _stated_end(path: Path, size: int) -> int:
    """Return the byte where the outermost chunks end; 0 where they do not say.

    RIFF chunks of AVI, boxes of MP4 (ISO/IEC 14496-12, 4.2), elements of Matroska (RFC 8794, 4-6).
    """
    end = chunks = 0
    with path.open("rb") as file:
        while end < size:
            chunks += 1
            if chunks > MOST_CHUNKS:
                raise InputError(path, f"damaged: more than {MOST_CHUNKS} chunks at the top level")
            file.seek(end)
            head = file.read(16)
            if head[:4] == b"RIFF":
                length = 8 + int.from_bytes(head[4:8], "little")
            elif path.suffix.lower() in {".mp4", ".mov", ".m4v", ".3gp"}:
                length = _box_length(head)
            elif path.suffix.lower() in {".mkv", ".webm"}:
                length = _element_length(head)
            else:
                return end
            if length == 0:
                return 0
            end += length
    return end


def _box_length(head: bytes) -> int:
    length = int.from_bytes(head[:4])
    return int.from_bytes(head[8:16]) if length == 1 else length


def _element_length(head: bytes) -> int:
    """Return the length of an element with its head; 0 where it is unknown or none."""
    name = _vint_width(head)
    width = _vint_width(head[name:])
    if name == 0 or width == 0:
        return 0
    value = int.from_bytes(head[name : name + width]) & ((1 << 7 * width) - 1)
    return 0 if value == (1 << 7 * width) - 1 else name + width + value


def _vint_width(head: bytes) -> int:
    """Return how many bytes a variable-size integer takes: one more than its leading zeros."""
    return 9 - head[0].bit_length() if head and head[0] else 0
