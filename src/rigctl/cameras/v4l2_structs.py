"""What a video device asks of the kernel: its few calls, their structures, and its grey formats.

Sizes, offsets and numbers are those of linux/videodev2.h on 64-bit Linux, as its header gives them
to a C compiler on x86-64 and arm64; the tests hold them.
"""

from __future__ import annotations

import fcntl
import mmap
import os
import select
import struct
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from rigctl.config import PixelFormatName

COMPRESSED: Final = ("MJPG", "JPEG", "H264", "HEVC", "MPEG", "VP80", "VP90")
"""Codes of formats whose compression changes grey levels: refused."""


@dataclass(frozen=True, slots=True)
class GreyFormat:
    """Where the grey level of a pixel lies (linux/videodev2.h).

    Attributes
    ----------
    code
        The format's four characters as a little-endian number.
    bytes_per_pixel
        Between one grey level and the next.
    first
        Byte of the first grey level in a line.
    bits
        Of a grey level; above 8 it takes two bytes, the lower first, its bits at the lower end.
    """

    code: int
    bytes_per_pixel: int
    first: int
    bits: int

    def grey(self, lines: NDArray[np.uint8], columns: int) -> NDArray[np.uint8]:
        """Return grey levels, shape (rows, columns), of lines of bytes, shape (rows, bytes).

        More than 8 bits are rounded to 8: half a level at most, below the noise of a sensor.
        """
        used = lines[:, : columns * self.bytes_per_pixel]
        if self.bits == 8:
            return used[:, self.first :: self.bytes_per_pixel]
        levels = np.ascontiguousarray(used).view("<u2")
        shift = self.bits - 8
        rounded = (levels.astype(np.uint32) + (1 << (shift - 1))) >> shift
        grey: NDArray[np.uint8] = np.minimum(rounded, 255).astype(np.uint8)
        return grey


def code_of(characters: str) -> int:
    """Return a format's code: its characters, blanks behind them, as a little-endian number."""
    return int.from_bytes(characters.ljust(4).encode("ascii"), "little")


GREY_FORMATS: Final[dict[PixelFormatName, GreyFormat]] = {
    "GREY": GreyFormat(code_of("GREY"), 1, 0, 8),
    "YUYV": GreyFormat(code_of("YUYV"), 2, 0, 8),
    "UYVY": GreyFormat(code_of("UYVY"), 2, 1, 8),
    "Y10": GreyFormat(code_of("Y10"), 2, 0, 10),
    "Y12": GreyFormat(code_of("Y12"), 2, 0, 12),
    "Y16": GreyFormat(code_of("Y16"), 2, 0, 16),
}
"""Of YUYV and UYVY only the brightness is used; it usually runs from 16 to 235."""


class Mapping(Protocol):
    """A mapped buffer: sliced for its bytes, closed to unmap it."""

    def __getitem__(self, place: slice, /) -> bytes:
        """Return a copy of some of its bytes."""

    def close(self) -> None:
        """Unmap it."""


class Kernel(Protocol):
    """Calls on a device node; each raises `OSError` as the system call does."""

    def open(self, path: str) -> int:
        """Open for reading and writing without blocking; return the descriptor."""

    def ioctl(self, descriptor: int, request: int, argument: bytearray) -> None:
        """Call with a buffer that the kernel reads and writes in place."""

    def map(self, descriptor: int, length: int, offset: int) -> Mapping:
        """Map a driver's buffer, shared."""

    def readable(self, descriptor: int, timeout_s: float) -> bool:
        """Wait until a filled buffer is there; False when the time is over."""

    def close(self, descriptor: int) -> None:
        """Close the descriptor."""


class LinuxKernel:
    """The system calls themselves."""

    def open(self, path: str) -> int:
        """Open for reading and writing without blocking."""
        return os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)

    def ioctl(self, descriptor: int, request: int, argument: bytearray) -> None:
        """Call ioctl with a mutable buffer."""
        fcntl.ioctl(descriptor, request, argument, True)

    def map(self, descriptor: int, length: int, offset: int) -> Mapping:
        """Map shared, for reading and writing as drivers expect."""
        return mmap.mmap(descriptor, length, mmap.MAP_SHARED, offset=offset)

    def readable(self, descriptor: int, timeout_s: float) -> bool:
        """Wait with select."""
        ready, _, _ = select.select([descriptor], [], [], timeout_s)
        return bool(ready)

    def close(self, descriptor: int) -> None:
        """Close the descriptor."""
        os.close(descriptor)


CAPTURE = 1
"""V4L2_BUF_TYPE_VIDEO_CAPTURE."""

_MMAP = 1
_FIELD_NONE = 1
_CAN_CAPTURE, _CAN_STREAM, _HAS_DEVICE_CAPS = 0x1, 0x0400_0000, 0x8000_0000
_FLAG_ERROR = 0x40
_CLOCK_MASK, _CLOCK_MONOTONIC = 0xE000, 0x2000

_NONE, _WRITE, _READ = 0, 1, 2


def _request(direction: int, number: int, size: int) -> int:
    return direction << 30 | size << 16 | ord("V") << 8 | number


CAPABILITY = struct.Struct("=16s32s32sIII12x")
"""struct v4l2_capability: driver, card, bus, version, capabilities, device_caps; 104 bytes."""

FORMAT = struct.Struct("=I4xIIIIII176x")
"""struct v4l2_format: type, width, height, pixelformat, field, bytesperline, sizeimage; 208."""

REQUEST_BUFFERS = struct.Struct("=III8x")
"""struct v4l2_requestbuffers: count, type, memory; 20 bytes."""

BUFFER = struct.Struct("=IIIII4xqq16sIIQIIi4x")
"""struct v4l2_buffer: index, type, bytesused, flags, field, seconds, microseconds, timecode,
sequence, memory, offset, length, reserved, request; 88 bytes."""

INTEGER = struct.Struct("=i")

QUERYCAP = _request(_READ, 0, CAPABILITY.size)
S_FMT = _request(_READ | _WRITE, 5, FORMAT.size)
REQBUFS = _request(_READ | _WRITE, 8, REQUEST_BUFFERS.size)
QUERYBUF = _request(_READ | _WRITE, 9, BUFFER.size)
QBUF = _request(_READ | _WRITE, 15, BUFFER.size)
DQBUF = _request(_READ | _WRITE, 17, BUFFER.size)
STREAMON = _request(_WRITE, 18, INTEGER.size)
STREAMOFF = _request(_WRITE, 19, INTEGER.size)
S_INPUT = _request(_READ | _WRITE, 39, INTEGER.size)


@dataclass(frozen=True, slots=True)
class PixelFormat:
    """What a driver granted: size in pixels, code, bytes of one line and of one image."""

    width: int
    height: int
    code: int
    line_bytes: int
    image_bytes: int


@dataclass(frozen=True, slots=True)
class Dequeued:
    """One filled buffer.

    Attributes
    ----------
    time_s
        The kernel's time stamp in seconds.
    damaged
        The driver's error flag.
    monotonic
        The time stamp is of the monotonic clock.
    """

    index: int
    bytes_used: int
    time_s: float
    sequence: int
    damaged: bool
    monotonic: bool


def can_stream(capability: bytes | bytearray) -> bool:
    """Say whether the device captures video by streaming (answer to VIDIOC_QUERYCAP)."""
    *_, whole, device = CAPABILITY.unpack(capability)
    flags = device if whole & _HAS_DEVICE_CAPS else whole
    wanted = _CAN_CAPTURE | _CAN_STREAM
    return bool(flags & wanted == wanted)


def ask_format(width: int, height: int, code: int) -> bytearray:
    """Return the argument of VIDIOC_S_FMT for this size in pixels and this pixel format."""
    return bytearray(FORMAT.pack(CAPTURE, width, height, code, _FIELD_NONE, 0, 0))


def granted_format(answer: bytes | bytearray) -> PixelFormat:
    """Return what the driver wrote back into the argument of VIDIOC_S_FMT."""
    _, width, height, code, _, line_bytes, image_bytes = FORMAT.unpack(answer)
    return PixelFormat(width, height, code, line_bytes, image_bytes)


def ask_buffers(count: int) -> bytearray:
    """Return the argument of VIDIOC_REQBUFS; a count of 0 frees them."""
    return bytearray(REQUEST_BUFFERS.pack(count, CAPTURE, _MMAP))


def granted_buffers(answer: bytes | bytearray) -> int:
    """Return how many buffers the driver gives."""
    count: int = REQUEST_BUFFERS.unpack(answer)[0]
    return count


def buffer(index: int = 0) -> bytearray:
    """Return the argument of VIDIOC_QUERYBUF, QBUF and DQBUF for one buffer."""
    return bytearray(BUFFER.pack(index, CAPTURE, 0, 0, 0, 0, 0, b"", 0, _MMAP, 0, 0, 0, 0))


def mapping(answer: bytes | bytearray) -> tuple[int, int]:
    """Return length and offset in bytes at which a buffer is mapped (answer to QUERYBUF)."""
    values = BUFFER.unpack(answer)
    # The offset is the 32-bit member of a union with a pointer.
    return values[11], values[10] & 0xFFFF_FFFF


def dequeued(answer: bytes | bytearray) -> Dequeued:
    """Take apart the answer to VIDIOC_DQBUF."""
    values = BUFFER.unpack(answer)
    index, _, used, flags, _, seconds, microseconds, _, sequence, *_ = values
    return Dequeued(
        index=index,
        bytes_used=used,
        time_s=seconds + microseconds * 1e-6,
        sequence=sequence,
        damaged=bool(flags & _FLAG_ERROR),
        monotonic=flags & _CLOCK_MASK == _CLOCK_MONOTONIC,
    )
