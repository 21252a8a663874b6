"""Films of high-speed cameras: Photron (.cih, .cihx with .mraw) and Phantom (.cine).

Photron's header, text or XML, names size, bits, rate, exposure and number of frames. Pixels of 10
and 12 bits are packed without gaps, the first one in the highest bits.

A .cine has a header, each frame's place in the file, its time and its pixels, little-endian. Grey
films of 8 and 16 bits a pixel and of 12 bits packed are read; frames of 10 and 12 bits that lie in
16 keep their numbers. Those of 10 bits packed follow a curve of their own, and mosaics of colours
are no grey pictures: both are refused. The picture stands on its head where its height is positive,
as in a bitmap.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.films.film import Film, FilmHead, Picture
from analysis.errors import InputError
from analysis.files import FrameBudget, read_bytes

_HEADER = struct.Struct("<2sHHHiIiIIIIII")
_BITMAP = struct.Struct("<IiiHHIIiiII")
_TAG = struct.Struct("<IHH")
_PACKED = {1024: 12}
"""Compression codes of the bitmap: bits of a packed pixel."""
TIMES, EXPOSURES = 1002, 1003
"""Kinds of tagged blocks: each frame's time and exposure."""
FRACTION = 2.0**32
MOST_BLOCKS = 100


class _Head(NamedTuple):
    frames: int
    bitmap_at: int
    setup_at: int
    offsets_at: int


class CineFilm(Film):
    """A grey film of a Phantom camera.

    Raises
    ------
    InputError
        It is no such file, is compressed or in colour, or ends before its header says.
    """

    def __init__(self, path: Path) -> None:
        self._size = path.stat().st_size
        with path.open("rb") as file:
            try:
                head = _head(file)
                file.seek(head.bitmap_at)
                bitmap = _BITMAP.unpack(file.read(_BITMAP.size))
                _, width, height, _, bits, compression, *_ = bitmap
                times, exposures = _tagged(file, head)
                file.seek(head.offsets_at)
                offsets = np.frombuffer(file.read(8 * head.frames), "<i8")
            except (struct.error, ValueError) as error:
                raise InputError(path, f"not a whole .cine file: {error}") from error
        if len(offsets) < head.frames:
            raise InputError(
                path, f"truncated: {len(offsets)} of {head.frames} frames have a place"
            )
        self._packed = _PACKED.get(compression)
        if bits not in {8, 16} or (compression and self._packed is None):
            raise InputError(
                path,
                f"{bits} bits a pixel, compression {compression}; read are grey films of 8 or 16 "
                "bits, plain or packed; save it so",
            )
        self._offsets, self._bits, self._on_its_head = offsets, bits, height > 0
        budget = FrameBudget(path)
        budget.require_frames(head.frames)
        budget.claim((abs(height), width), 2)
        count = abs(height) * width
        self._bytes = count * bits // 8 if self._packed is None else -(-count * self._packed // 8)
        exposure = float(np.median(exposures)) if len(exposures) else None
        super().__init__(
            path,
            FilmHead(head.frames, abs(height), width, 1, times_s=times, exposure_s=exposure),
        )

    def _read(self) -> Iterator[Picture]:
        head = self.head
        with self.path.open("rb") as file:
            for number, offset in enumerate(self._offsets.tolist()):
                file.seek(offset)
                note = file.read(4)
                length = int.from_bytes(note, "little")
                file.seek(offset + length)
                content = file.read(self._bytes)
                if not note or len(content) < self._bytes:
                    raise InputError(
                        self.path,
                        f"truncated in frame {number}: it ends at byte {offset + length} + "
                        f"{self._bytes}, the file at {self._size}",
                    )
                values = self._values(content)[: head.height * head.width]
                picture = values.reshape(head.height, head.width, 1)
                if self._on_its_head and self._packed is None:
                    picture = picture[::-1]
                yield cast("Picture", np.ascontiguousarray(picture))

    def _values(self, content: bytes) -> NDArray[np.uint8] | NDArray[np.uint16]:
        return unpacked(content, self._bits if self._packed is None else self._packed)


def _head(file: BinaryIO) -> _Head:
    fields = _HEADER.unpack(file.read(_HEADER.size))
    mark, _, compression, _, _, _, _, frames, bitmap_at, setup_at, offsets_at, *_ = fields
    if mark != b"CI":
        raise ValueError("it does not begin with CI")
    if compression != 0:
        raise ValueError(
            f"its frames are of kind {compression} (1: JPEG, 2: mosaic of colours), 0 is read"
        )
    if frames == 0:
        raise ValueError("it holds no frames")
    return _Head(frames, bitmap_at, setup_at, offsets_at)


def _tagged(file: BinaryIO, head: _Head) -> tuple[Floats | None, Floats]:
    """Return each frame's time and exposure in s, from the blocks behind the setup."""
    file.seek(head.setup_at + 140)
    setup_marks = file.read(4)
    length = int.from_bytes(setup_marks[2:4], "little")
    at = head.setup_at + length
    times: Floats | None = None
    exposures = np.empty(0)
    for _ in range(MOST_BLOCKS):
        if length == 0 or at + _TAG.size > head.offsets_at:
            break
        file.seek(at)
        block, kind, _ = _TAG.unpack(file.read(_TAG.size))
        if block < _TAG.size:
            break
        if kind == TIMES:
            raw = np.frombuffer(file.read(8 * head.frames), "<u8")
            whole, part = raw >> np.uint64(32), raw & np.uint64(0xFFFFFFFF)
            seconds = (whole - whole[0]).astype(np.float64) + part / FRACTION
            times = np.asarray(seconds - seconds[0])
        elif kind == EXPOSURES:
            exposures = np.frombuffer(file.read(4 * head.frames), "<u4") / FRACTION
        at += block
    if times is not None and (len(times) != head.frames or not np.all(np.diff(times) > 0)):
        times = None
    return times, exposures


HEADER_SUFFIXES = (".cih", ".cihx")
FRAMES_SUFFIX = ".mraw"
BITS = (8, 10, 12, 16)
_LINE = re.compile(r"^\s*([^:\n]+?)\s*:\s*(.*?)\s*$", re.M)
_XML = {
    "Record Rate(fps)": "recordRate",
    "Total Frame": "totalFrame",
    "Image Width": "width",
    "Image Height": "height",
    "Color Bit": "bit",
    "Shutter Speed(s)": "shutterSpeed",
}


class PhotronFilm(Film):
    """Frames of a .mraw file as its header describes them; given either of the two.

    Raises
    ------
    InputError
        One of the two is missing, the header lacks a field, or there are fewer bytes than it says.
    """

    def __init__(self, path: Path) -> None:
        header, self._raw = _both(path)
        fields = _fields(header)
        self._bits = _whole(header, fields, "Color Bit")
        height, width = (_whole(header, fields, f"Image {side}") for side in ("Height", "Width"))
        frames = _whole(header, fields, "Total Frame")
        if self._bits not in BITS:
            raise InputError(header, f"{self._bits} bits a pixel; read are {BITS}, one channel")
        self._frame_bytes = -(-height * width * self._bits // 8)
        size = self._raw.stat().st_size
        if size < frames * self._frame_bytes:
            whole = size // self._frame_bytes
            raise InputError(
                self._raw,
                f"truncated: {size} bytes are {whole} whole frames of {height} x {width} pixels of "
                f"{self._bits} bits, the header counts {frames}",
            )
        budget = FrameBudget(self._raw)
        budget.require_frames(frames)
        budget.claim((height, width), 2)
        rate = _number(header, fields, "Record Rate(fps)")
        super().__init__(
            self._raw,
            FilmHead(frames, height, width, 1, rate_hz=rate, exposure_s=_exposure(fields)),
        )

    def _read(self) -> Iterator[Picture]:
        head = self.head
        with self._raw.open("rb") as file:
            for _ in range(head.frames):
                values = unpacked(file.read(self._frame_bytes), self._bits)
                shape = (head.height, head.width, 1)
                yield cast("Picture", values[: head.height * head.width].reshape(shape))


def unpacked(content: bytes, bits: int) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """Return pixels of 8, 10, 12 or 16 bits; 10 and 12 are packed, highest bits first."""
    if bits == 8:
        return np.frombuffer(content, np.uint8)
    if bits == 16:
        return np.frombuffer(content, "<u2").astype(np.uint16)
    group = 3 if bits == 12 else 5
    pixels = group * 8 // bits
    padded = content + bytes(-len(content) % group)
    packed = np.frombuffer(padded, np.uint8).reshape(-1, group).astype(np.uint64)
    word = np.zeros(len(packed), np.uint64)
    for k in range(group):
        word = (word << np.uint64(8)) | packed[:, k]
    shifts = [np.uint64((pixels - 1 - k) * bits) for k in range(pixels)]
    mask = np.uint64(2**bits - 1)
    return np.stack([(word >> shift) & mask for shift in shifts], axis=1).ravel().astype(np.uint16)


def _both(path: Path) -> tuple[Path, Path]:
    raw = path.with_suffix(FRAMES_SUFFIX)
    headers = [path.with_suffix(suffix) for suffix in reversed(HEADER_SUFFIXES)]
    header = next((each for each in headers if each.exists()), None)
    if header is None:
        raise InputError(path, f"no header {' or '.join(HEADER_SUFFIXES)} of that name beside it")
    if not raw.exists():
        raise InputError(header, f"no frames {raw.name} beside it")
    return header, raw


def _fields(header: Path) -> dict[str, str]:
    text = read_bytes(header, "settings_kb").decode("utf-8", errors="replace")
    if header.suffix.lower() == HEADER_SUFFIXES[0]:
        return dict(_LINE.findall(text))
    found = {}
    for name, tag in _XML.items():
        match = re.search(rf"<{tag}>\s*([^<]+?)\s*</{tag}>", text)
        if match:
            found[name] = match[1]
    return found


def _number(header: Path, fields: dict[str, str], name: str) -> float:
    try:
        value = float(fields[name])
    except KeyError as error:
        raise InputError(header, f"does not say {name!r}") from error
    except ValueError as error:
        raise InputError(header, f"{name}: {fields[name]!r} is no number") from error
    if not 0 < value < float("inf"):
        raise InputError(header, f"{name}: {value:g} is not more than 0")
    return value


def _whole(header: Path, fields: dict[str, str], name: str) -> int:
    return int(_number(header, fields, name))


def _exposure(fields: dict[str, str]) -> float | None:
    """Return the shutter's time: written as 1/N of a second, or in seconds."""
    text = fields.get("Shutter Speed(s)", "")
    match = re.fullmatch(r"1\s*/\s*([0-9.]+)", text)
    try:
        value = 1.0 / float(match[1]) if match else float(text)
    except (ValueError, ZeroDivisionError):
        return None
    # An XML header counts in whole numbers of 1/N s.
    return 1.0 / value if value > 1.0 else value
