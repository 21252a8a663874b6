"""Valid content broken by chance, with and without knowledge of its form."""

from __future__ import annotations

import random
import re
import struct
import zlib

EXTREMES = (0, 1, 2, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
NUMBERS = (
    "0", "-1", "1e308", "-1e400", "nan", "inf", "0.5", "9" * 20, "9" * 400, "9" * 5000,
    "0x" + "f" * 5000, "1_000", "1e-400", "1.", "00", "true", "-0", "4294967296",
    "9223372036854775808", "1e5", "100000",
)  # fmt: skip
TEXTS = (
    "", '""', "''", "null", "[]", "{}", "[" * 3000, '{"a":' * 3000, "a." * 3000 + "a = 1",
    "\0", "\ufeff", "\u202e", "\ud800", "é", "a" * 200_000, ",", '"', "\n", "\r", "#", "=",
    "2026-13-45", "../../etc/passwd", "%s%n", "[[1],[2,3]]", '{"a": 1, "a": 2}',
)  # fmt: skip
MOST_BYTES = 3_000_000
_WORD = re.compile(rb"[A-Za-z0-9_.+-]+")
_TAG = struct.Struct("<HHII")


def broken(content: bytes, name: str, others: list[bytes], rng: random.Random) -> bytes:
    """Return content with one to four changes; `others` are files to splice with."""
    suffix = name.rpartition(".")[2]
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        own = _BY_FORM.get(suffix)
        if own is not None and rng.random() < 0.5:
            content = own(content, rng)
        else:
            content = rng.choice(_ANYWHERE)(content, rng, others)
        content = content[:MOST_BYTES]
    return content


def _flip(content: bytes, rng: random.Random, _: list[bytes]) -> bytes:
    changed = bytearray(content)
    for _bit in range(rng.choice((1, 1, 4, 32))):
        if changed:
            changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _cut(content: bytes, rng: random.Random, _: list[bytes]) -> bytes:
    return content[: rng.randrange(len(content) + 1)]


def _insert(content: bytes, rng: random.Random, _: list[bytes]) -> bytes:
    place = rng.randrange(len(content) + 1)
    what = rng.choice((rng.randbytes(rng.choice((1, 4, 64))), bytes(1000), b"\xff" * 16))
    return content[:place] + what + content[place:]


def _remove(content: bytes, rng: random.Random, _: list[bytes]) -> bytes:
    place = rng.randrange(len(content) + 1)
    return content[:place] + content[place + rng.choice((1, 2, 8, 100)) :]


def _repeat(content: bytes, rng: random.Random, _: list[bytes]) -> bytes:
    first, last = sorted(rng.randrange(len(content) + 1) for _ in range(2))
    return content[:last] + content[first:last] * rng.choice((1, 2, 50)) + content[last:]


def _splice(content: bytes, rng: random.Random, others: list[bytes]) -> bytes:
    other = rng.choice(others)
    return content[: rng.randrange(len(content) + 1)] + other[rng.randrange(len(other) + 1) :]


def _number(content: bytes, rng: random.Random, _: list[bytes]) -> bytes:
    """Set a field of 1 to 8 bytes, more often near the beginning, where lengths stand."""
    width = rng.choice((1, 2, 4, 8))
    if len(content) < width:
        return content
    most = len(content) - width
    place = rng.randrange(min(most, 300) + 1) if rng.random() < 0.6 else rng.randrange(most + 1)
    largest = (1 << 8 * width) - 1
    value = rng.choice((*EXTREMES, len(content), largest)) & largest
    field = value.to_bytes(width, "little" if rng.random() < 0.5 else "big")
    return content[:place] + field + content[place + width :]


def _tiff(content: bytes, rng: random.Random) -> bytes:
    """Change a tag of a little-endian directory, or where the next one lies."""
    changed, places = bytearray(content), _directories(content)
    if not places:
        return content
    place = rng.choice(places)
    (tags,) = struct.unpack_from("<H", content, place)
    end = place + 2 + _TAG.size * tags
    if tags == 0 or end + 4 > len(content) or rng.random() < 0.25:
        if end + 4 <= len(content):
            goal = rng.choice((*places, place + 2, len(content), 8, 0xFFFFFFFF))
            struct.pack_into("<I", changed, end, goal)
        return bytes(changed)
    at = place + 2 + _TAG.size * rng.randrange(tags)
    fields = list(_TAG.unpack_from(content, at))
    field = rng.randrange(4)
    values = (rng.choice((254, 256, 257, 258, 259, 273, 277, 279, 317, 322, 330, 32997)),)
    fields[field] = rng.choice(values if field == 0 else EXTREMES) % (2**16 if field < 2 else 2**32)
    _TAG.pack_into(changed, at, *fields)
    return bytes(changed)


def _directories(content: bytes) -> list[int]:
    if content[:4] != b"II*\0" or len(content) < 8:
        return []
    places: list[int] = []
    (place,) = struct.unpack_from("<I", content, 4)
    while 8 <= place < len(content) - 2 and place not in places:
        places.append(place)
        (tags,) = struct.unpack_from("<H", content, place)
        end = place + 2 + _TAG.size * tags
        place = struct.unpack_from("<I", content, end)[0] if end + 4 <= len(content) else 0
    return places


def _png(content: bytes, rng: random.Random) -> bytes:
    """Change a chunk and its check sum with it, repeat it, or leave it out."""
    chunks, place = [], 8
    while place + 12 <= len(content):
        (length,) = struct.unpack_from(">I", content, place)
        chunks.append((content[place + 4 : place + 8], content[place + 8 : place + 8 + length]))
        place += 12 + length
    if not chunks:
        return content
    k = rng.randrange(len(chunks))
    name, body = chunks[k]
    match rng.randrange(4):
        case 0:
            chunks[k] = name, _number(body, rng, [])
        case 1:
            chunks[k : k + 1] = [chunks[k]] * rng.choice((0, 2, 100))
        case 2:
            packed = zlib.compress(bytes(rng.choice((0, 1, 10**6, 5 * 10**7))))
            chunks[k] = rng.choice((b"IDAT", b"zTXt", b"iCCP", b"fcTL")), b"x\0\0" + packed
        case _:
            chunks[k] = name, struct.pack(">I", rng.choice(EXTREMES)) + body[4:]
    whole = b"".join(
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
        for name, body in chunks
    )
    return content[:8] + whole


def _npy(content: bytes, rng: random.Random) -> bytes:
    """Write another header."""
    kind = rng.choice(("|u1", "<u2", "<f8", "|O", "|V0", "<U99999999", "|S4", "M8[s]", "x"))
    shapes = ("(6, 16, 24)", "(1000000000000, 4, 4)", "()", "(0, 4, 4)", "(-1, 4, 4)", "(6,)")
    shape = rng.choice((*shapes, f"({'9' * 400},)", "6", "'a'", "(2.5,)", "((((", "(6,) * 99999"))
    text = f"{{'descr': '{kind}', 'fortran_order': {rng.choice((0, True))}, 'shape': {shape}, }}\n"
    header = rng.choice((text, text, "(" * 5000, "[]", "{}", "\0" * 64, "1" * 5000)).encode()
    length = rng.choice((len(header), len(header), 0, 0xFFFF))
    return content[:6] + rng.choice((b"\1\0", b"\2\0", b"\3\0", b"\xff\xff")) + struct.pack(
        "<H", length
    ) + header + content[128:]  # fmt: skip


def _text(content: bytes, rng: random.Random) -> bytes:
    """Put a number or a text beyond expectation in the place of a word, or beside it."""
    word = _WORD.search(content, rng.randrange(len(content) + 1)) or _WORD.search(content)
    if word is None:
        return content
    what = rng.choice(rng.choice((NUMBERS, TEXTS))).encode(errors="surrogatepass")
    first, last = word.span()
    return content[: rng.choice((first, first, last))] + what + content[last:]


def _lines(content: bytes, rng: random.Random) -> bytes:
    """Repeat, drop or exchange lines, or change a word."""
    lines = content.split(b"\n")
    k, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(6):
        case 0:
            lines[k : k + 1] = [lines[k][:1000]] * rng.choice((0, 2, 3000))
        case 1:
            lines[k], lines[other] = lines[other], lines[k]
        case 2:
            lines[k] = lines[k][:3000] * rng.choice((2, 1000))
        case _:
            return _text(content, rng)
    return b"\n".join(lines)


_ANYWHERE = (_flip, _flip, _cut, _insert, _remove, _repeat, _splice, _number, _number)
_BY_FORM = {
    "tiff": _tiff, "tif": _tiff, "png": _png, "npy": _npy, "json": _text, "toml": _lines,
    "csv": _lines,
}  # fmt: skip
