"""The layouts against linux/videodev2.h: its declarations by ctypes, its numbers by hand."""

from __future__ import annotations

import ctypes as c

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigctl.cameras import v4l2_structs as v4l2
from rigctl.cameras.v4l2_structs import code_of


class Capability(c.Structure):
    _fields_ = (
        ("driver", c.c_uint8 * 16), ("card", c.c_uint8 * 32), ("bus_info", c.c_uint8 * 32),
        ("version", c.c_uint32), ("capabilities", c.c_uint32), ("device_caps", c.c_uint32),
        ("reserved", c.c_uint32 * 3),
    )  # fmt: skip


class PixFormat(c.Structure):
    _fields_ = tuple(
        (name, c.c_uint32)
        for name in (
            "width", "height", "pixelformat", "field", "bytesperline", "sizeimage",
            "colorspace", "priv", "flags", "encoding", "quantization", "xfer_func",
        )
    )  # fmt: skip


class FormatUnion(c.Union):
    # The window member of the union holds pointers, which align it to 8 bytes.
    _fields_ = (("pix", PixFormat), ("raw", c.c_uint8 * 200), ("pointer", c.c_void_p))


class Format(c.Structure):
    _fields_ = (("type", c.c_uint32), ("fmt", FormatUnion))


class RequestBuffers(c.Structure):
    _fields_ = (
        ("count", c.c_uint32), ("type", c.c_uint32), ("memory", c.c_uint32),
        ("capabilities", c.c_uint32), ("flags", c.c_uint8), ("reserved", c.c_uint8 * 3),
    )  # fmt: skip


class TimeValue(c.Structure):
    _fields_ = (("seconds", c.c_long), ("microseconds", c.c_long))


class Timecode(c.Structure):
    _fields_ = (
        ("type", c.c_uint32), ("flags", c.c_uint32), ("frames", c.c_uint8),
        ("seconds", c.c_uint8), ("minutes", c.c_uint8), ("hours", c.c_uint8),
        ("userbits", c.c_uint8 * 4),
    )  # fmt: skip


class Place(c.Union):
    _fields_ = (("offset", c.c_uint32), ("userptr", c.c_ulong), ("fd", c.c_int32))


class Buffer(c.Structure):
    _fields_ = (
        ("index", c.c_uint32), ("type", c.c_uint32), ("bytesused", c.c_uint32),
        ("flags", c.c_uint32), ("field", c.c_uint32), ("timestamp", TimeValue),
        ("timecode", Timecode), ("sequence", c.c_uint32), ("memory", c.c_uint32), ("m", Place),
        ("length", c.c_uint32), ("reserved2", c.c_uint32), ("request_fd", c.c_int32),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("ours", "declared", "size"),
    [
        (v4l2.CAPABILITY, Capability, 104),
        (v4l2.FORMAT, Format, 208),
        (v4l2.REQUEST_BUFFERS, RequestBuffers, 20),
        (v4l2.BUFFER, Buffer, 88),
    ],
)
def test_sizes_are_those_of_the_header(
    ours: v4l2.struct.Struct, declared: type[c.Structure], size: int
) -> None:
    assert ours.size == size == c.sizeof(declared)


@pytest.mark.parametrize(
    ("ours", "number"),
    [
        (v4l2.QUERYCAP, 0x80685600),
        (v4l2.S_FMT, 0xC0D05605),
        (v4l2.REQBUFS, 0xC0145608),
        (v4l2.QUERYBUF, 0xC0585609),
        (v4l2.QBUF, 0xC058560F),
        (v4l2.DQBUF, 0xC0585611),
        (v4l2.STREAMON, 0x40045612),
        (v4l2.STREAMOFF, 0x40045613),
        (v4l2.S_INPUT, 0xC0045627),
        (code_of("GREY"), 0x59455247),
    ],
)
def test_request_numbers_are_those_a_c_compiler_makes_of_the_header(ours: int, number: int) -> None:
    assert ours == number


def test_a_wish_for_a_format_lies_where_the_header_puts_it() -> None:
    asked = Format.from_buffer(v4l2.ask_format(240, 192, 0x59455247))
    pix = asked.fmt.pix
    assert (asked.type, pix.width, pix.height, pix.pixelformat) == (1, 240, 192, 0x59455247)


def test_a_granted_format_is_read_from_where_the_header_puts_it() -> None:
    answer = Format(type=1)
    pix = answer.fmt.pix
    pix.width, pix.height, pix.pixelformat = 240, 192, 0x59455247
    pix.bytesperline, pix.sizeimage = 256, 49152
    found = v4l2.granted_format(bytes(answer))
    assert found == v4l2.PixelFormat(240, 192, 0x59455247, 256, 49152)


@given(
    index=st.integers(0, 31),
    used=st.integers(0, 2**32 - 1),
    moment=st.tuples(st.integers(0, 10**9), st.integers(0, 999_999)),
    sequence=st.integers(0, 2**32 - 1),
    damaged=st.booleans(),
)
def test_a_filled_buffer_is_read_from_where_the_header_puts_it(
    index: int, used: int, moment: tuple[int, int], sequence: int, damaged: bool
) -> None:
    seconds, microseconds = moment
    answer = Buffer(index=index, type=1, bytesused=used, sequence=sequence)
    answer.flags = 0x2000 | (0x40 if damaged else 0)
    answer.timestamp.seconds, answer.timestamp.microseconds = seconds, microseconds
    found = v4l2.dequeued(bytes(answer))
    assert (found.index, found.bytes_used, found.sequence) == (index, used, sequence)
    assert found.time_s == pytest.approx(seconds + microseconds / 1e6, abs=1e-6)
    assert (found.damaged, found.monotonic) == (damaged, True)


@pytest.mark.parametrize("flags", [0x0000, 0x4000, 0x6000])
def test_another_clock_than_the_monotonic_one_is_told(flags: int) -> None:
    assert not v4l2.dequeued(bytes(Buffer(flags=flags))).monotonic


def test_a_buffers_place_is_read_from_where_the_header_puts_it() -> None:
    answer = Buffer(length=46080)
    answer.m.offset = 0x80001000
    assert v4l2.mapping(bytes(answer)) == (46080, 0x80001000)
    asked = Buffer.from_buffer(v4l2.buffer(3))
    assert (asked.index, asked.type, asked.memory) == (3, 1, 1)


def test_a_wish_for_buffers_and_its_answer_lie_where_the_header_puts_them() -> None:
    asked = RequestBuffers.from_buffer(v4l2.ask_buffers(8))
    assert (asked.count, asked.type, asked.memory) == (8, 1, 1)
    assert v4l2.granted_buffers(bytes(RequestBuffers(count=5))) == 5


@pytest.mark.parametrize(
    ("whole", "device", "can"),
    [
        (0x0400_0001, 0, True),
        (0x0400_0000, 0, False),
        (0x0000_0001, 0, False),
        (0x8400_0001, 0x0400_0001, True),
        (0x8400_0001, 0x0400_0002, False),
    ],
)
def test_a_node_can_stream_only_if_it_says_so_for_itself(
    whole: int, device: int, can: bool
) -> None:
    answer = Capability(capabilities=whole, device_caps=device)
    assert v4l2.can_stream(bytes(answer)) is can
