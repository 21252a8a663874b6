"""Files made to exhaust their reader are refused in one sentence, at once and in little memory.

Each is read in a process of its own whose memory above what it begins with is bounded by the
system: what a reader claims beyond it fails there. These processes are copies of one that has
loaded the readers.
"""

from __future__ import annotations

import json
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

READER = """
import json, os, resource, sys, tempfile, time
from pathlib import Path
from analysis.errors import InputError
from analysis.exchange.contact_table import read_contacts
from analysis.exchange.description import read_description
from analysis.exchange.pose_table import read_poses
from analysis.exchange.shot_list import read_shot_list
from analysis.imaging.files.stack import read_stack
readers = {
    "campaign.toml": read_description, "shots.csv": read_shot_list, "poses.csv": read_poses,
    "contacts.csv": lambda path: read_contacts(path, plate=False),
}

def read(path):
    held = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (held + 1_000_000_000,) * 2)
    resource.setrlimit(resource.RLIMIT_CPU, (20, 20))
    began = time.process_time()
    try:
        readers.get(path.name, read_stack)(path)
    except InputError as error:
        return time.process_time() - began, str(error)
    return time.process_time() - began, "it was read"

for line in sys.stdin:
    with tempfile.TemporaryFile() as errors, tempfile.TemporaryFile() as answer:
        if os.fork() == 0:
            os.dup2(errors.fileno(), 2)
            answer.write(json.dumps(read(Path(json.loads(line)))).encode())
            answer.flush()
            os._exit(0)
        status = os.waitstatus_to_exitcode(os.wait()[1])
        errors.seek(0), answer.seek(0)
        texts = errors.read().decode(), answer.read().decode()
    print(json.dumps([status, *texts]), flush=True)
"""


class Reader:
    """A process that has loaded all readers, and reads each file in a copy of itself."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-c", READER],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def refused(self, path: Path) -> str:
        """Return the sentence of a refusal, which took less than 5 s of processor time."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(str(path)) + "\n")
        self._process.stdin.flush()
        status, errors, answer = json.loads(self._process.stdout.readline())
        assert (status, errors) == (0, "")
        spent, sentence = json.loads(answer)
        assert spent < 5.0
        assert len(sentence) < 2500
        return str(sentence)

    def end(self) -> None:
        """End the process."""
        self._process.communicate()


@pytest.fixture(scope="module")
def reader() -> Iterator[Reader]:
    running = Reader()
    yield running
    running.end()


def directory(
    following: int,
    *,
    width: int = 4,
    height: int = 4,
    data: tuple[int, int] = (8, 16),
    packed: bool = False,
) -> bytes:
    """Return a directory of a little-endian TIFF with one strip (TIFF 6.0, section 2)."""
    tags = [
        (256, width), (257, height), (258, 8), (259, 8 if packed else 1), (262, 1),
        (273, data[0]), (277, 1), (278, height), (279, data[1]),
    ]  # fmt: skip
    body = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags)
    return struct.pack("<H", len(tags)) + body + struct.pack("<I", following)


def tiff(path: Path, first: int, content: bytes) -> Path:
    path.write_bytes(b"II*\0" + struct.pack("<I", first) + content)
    return path


def packed_zeros(size: int) -> bytes:
    """Return so many zeros, a number of 2^20, in the form zlib (RFC 1950): one block repeated."""
    packer = zlib.compressobj(9, wbits=-15)
    block = packer.compress(bytes(2**20)) + packer.flush(zlib.Z_FULL_FLUSH)
    adler32 = (size % 65_521) << 16 | 1
    return b"\x78\xda" + block * (size // 2**20) + packer.flush() + struct.pack(">I", adler32)


def test_zeros_are_packed_as_they_are_unpacked() -> None:
    assert zlib.decompress(packed_zeros(3 * 2**20)) == bytes(3 * 2**20)


def looped(folder: Path) -> Path:
    return tiff(folder / "loop.tiff", 24, bytes(16) + directory(24))


def looped_after_two(folder: Path) -> Path:
    size = len(directory(0))
    second = directory(24) + b"\0" * (size % 2)
    return tiff(folder / "loop.tiff", 24, bytes(16) + directory(24 + size) + second)


def chained(folder: Path) -> Path:
    size = len(directory(0))
    chain = b"".join(directory(24 + (k + 1) * size) for k in range(20_000))
    return tiff(folder / "long.tiff", 24, bytes(16) + chain + directory(0))


def large_page(folder: Path) -> Path:
    return tiff(folder / "large.tiff", 8, directory(0, width=65_536, height=65_536, packed=True))


def packed_page(folder: Path) -> Path:
    data = packed_zeros(2**32)
    end = 8 + len(data) + len(data) % 2
    page = directory(0, width=64, height=64, data=(8, len(data)), packed=True)
    return tiff(folder / "packed.tiff", end, data.ljust(end - 8, b"\0") + page)


def many_values(folder: Path) -> Path:
    tag = struct.pack("<HHHII", 1, 273, 4, 8_000_000, 30)
    return tiff(folder / "values.tiff", 8, tag + bytes(4 + 4 * 8_000_000 + 30))


def chunk(name: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + name + content + struct.pack(
        ">I", zlib.crc32(name + content)
    )  # fmt: skip


def large_png(folder: Path) -> Path:
    (folder / "frames").mkdir()
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", 32_000, 32_000, 8, 0, 0, 0, 0))
    pixels = chunk(b"IDAT", packed_zeros(32_000 * 32_001))
    content = b"\x89PNG\r\n\x1a\n" + head + pixels + chunk(b"IEND", b"")
    (folder / "frames" / "0000.png").write_bytes(content)
    return folder / "frames"


def npy(header: str, content: bytes = b"") -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        path = folder / "frames.npy"
        path.write_bytes(
            b"\x93NUMPY\1\0" + struct.pack("<H", len(header)) + header.encode() + content
        )
        return path

    return write


Content = str | Callable[[], str]
"""Of a file; what is large is made when it is written: each process that runs tests loads this."""


def text(name: str, content: Content) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        path = folder / name
        path.write_text(content if isinstance(content, str) else content())
        return path

    return write


def times(content: Content) -> Callable[[Path], Path]:
    """Return what writes frames with such a JSON beside them, and names the JSON."""

    def write(folder: Path) -> Path:
        np.save(folder / "0001.npy", np.zeros((3, 4, 4), np.uint8))
        return text("0001.json", content)(folder)

    return write


FOLLOWED_BY_NONE = "{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2"
SPEAKS_OF = "{{'descr': '{}', 'fortran_order': False, 'shape': {}}}\n"
POSES = "shot,frame,t_s,sphere,x_m,y_m,z_m,sigma_x_m,sigma_y_m,sigma_z_m,qw,qx,qy,qz,sigma_rot_rad"

HOSTILE: dict[str, tuple[Callable[[Path], Path], str]] = {
    "a TIFF directory that follows itself": (looped, "directories go round, frame 1"),
    "TIFF directories that go round": (looped_after_two, "directories go round, frame 2"),
    "more TIFF pages than frames": (chained, "10001 frames or more, allowed are 10000"),
    "a TIFF page of 4 billion pixels": (large_page, "65536 x 65536 pixels, allowed are 16777216"),
    "a TIFF page that unpacks to 4 GB": (packed_page, "unpack to more than 8192 bytes"),
    "a TIFF tag of 8 million values": (many_values, "8000000 numbers in its tags"),
    "a PNG of a billion pixels": (large_png, "32000 x 32000 pixels, allowed are 16777216"),
    "an NPY header that is cut": (npy(FOLLOWED_BY_NONE), "not a whole NPY file"),
    "an NPY header of nested brackets": (npy("(" * 9000), "not a whole NPY file"),
    "an NPY header of 10^12 frames": (
        npy(SPEAKS_OF.format("|u1", (10**12, 4, 4)), bytes(64)),
        "speaks of 16000000000000 bytes, 64 follow",
    ),
    "an NPY header of frames without pixels": (
        npy(SPEAKS_OF.format("|u1", (10**12, 0, 4))),
        "frames or more, allowed are 10000",
    ),
    "an NPY header of values without bytes": (
        npy(SPEAKS_OF.format("|V0", (4, 4, 4))), "have no bytes"
    ),
    "TOML keys within keys": (
        text("campaign.toml", ".".join("a" * 60_000) + " = 1\n"), "line 1 has more than 200 dots"
    ),
    "TOML keys of digits within keys": (
        text("campaign.toml", ".".join("1" * 60_000) + " = 1\n"), "more than 200 dots"
    ),
    "quoted TOML keys within keys": (
        text("campaign.toml", '","."="' + '.",".1' * 30_000 + " = 1\n"), "more than 200 dots"
    ),
    "TOML lists within lists": (text("campaign.toml", "a = " + "[" * 100_000), "beyond 64 levels"),
    "a TOML number of 5000 digits": (text("campaign.toml", "a = " + "9" * 5000), "not TOML"),
    "a TOML number of 5000 hexadecimal digits": (
        text("campaign.toml", "format = 0x" + "f" * 5000), "does not fit into 64 bits"
    ),
    "TOML of 100 MB": (
        text("campaign.toml", lambda: "a = 1\n" * 16_000_000), "more than 256000 bytes"
    ),
    "JSON lists within lists": (times("[" * 100_000), "nested beyond 64 levels"),
    "JSON objects within objects": (times('{"a":' * 500 + "1" + "}" * 500), "beyond 64 levels"),
    "a JSON number of 4000 digits": (times(f'{{"times_s": [{"9" * 4000}]}}'), "64 bits"),
    "a JSON number of 5000 digits": (times(f'{{"times_s": [{"9" * 5000}]}}'), "not JSON"),
    "JSON of 70 MB": (
        times(lambda: "[" + "[]," * 23_000_000 + "[]]"), "more than 16000000 bytes"
    ),
    "a shot number of 5000 digits": (
        text("shots.csv", f"shot\n{'9' * 5000}\n"), "has 5000 digits, allowed are 15"
    ),
    "a pose of shot 10^20": (
        text("poses.csv", f"{POSES}\n{10**20},0,0,a{',' * 11}\n"), "has 21 digits, allowed are 15"
    ),
    "a line of 100 MB": (
        text("shots.csv", lambda: "shot" + "," * 10**8), "more than 1000000 characters"
    ),
    "100 000 columns of one name": (text("shots.csv", "shot" + ",x" * 10**5), "more than once"),
}  # fmt: skip


@pytest.mark.parametrize(("write", "reason"), HOSTILE.values(), ids=HOSTILE)
def test_a_file_made_to_exhaust_its_reader_is_refused_in_one_sentence(
    reader: Reader, tmp_path: Path, write: Callable[[Path], Path], reason: str
) -> None:
    path = write(tmp_path)
    read = path.with_suffix(".npy") if path.suffix == ".json" else path
    sentence = reader.refused(read)
    assert sentence.startswith(str(path))
    assert reason in sentence


def test_limits_are_settings_that_hold_in_processes_started_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "frames.npy"
    np.save(path, np.zeros((20, 4, 4), np.uint8))
    monkeypatch.setenv("RIGCTL_FILES", json.dumps({"frames": 19}))
    later = Reader()
    assert "20 frames or more, allowed are 19" in later.refused(path)
    later.end()
