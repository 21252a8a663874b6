"""Photron's films: a header of text (.cih) or XML (.cihx) beside raw frames (.mraw).

The header names size, bits, rate, exposure and number of frames. Pixels of 10 and 12 bits are
packed without gaps, the first one in the highest bits.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from analysis.balls.films.film import Film, FilmHead, Picture
from analysis.errors import InputError
from analysis.files import FrameBudget, read_bytes

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
