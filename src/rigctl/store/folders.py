"""One folder for each shot: raw frames and manifest never change, results are only added.

::

    shots/20260131/20260131-000042/frames.npy         uint8, shape (frames, rows, columns)
                                   manifest.json      settings, times, digests, with units
                                   result-0001.json   one for each analysis
                   20260131-000043/manifest.json      a shot without frames: why, and what flew
          i0007/i0007-000017/      shot 17 of the seventh imported campaign: frames as they came
                folder/            everything else of its exchange folder
                import.json        every file of that folder, with its digest
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from rigctl.cameras.frames import FrameSequence
from rigctl.errors import NotFoundError, StoreError
from rigctl.store.durable import (
    FOLDER_MODE,
    Room,
    make_folders,
    sync_folder,
    write_over_synced,
    write_synced,
)

if TYPE_CHECKING:
    from analysis.arrays import Grey
    from analysis.imaging.files.stack import FrameStack

_NAME = re.compile(r"(\d{8}|i\d{4,})-\d{6,}")
PARTIAL = ".partial"
"""Ending of what is being written."""
FRAMES = "frames.npy"


class ShotFolders:
    """The folders below `root`/shots."""

    def __init__(self, root: Path) -> None:
        self._shots = root / "shots"
        self.room = Room(self._shots)

    def folder(self, shot: str) -> Path:
        """Return where a shot's files are, or will be; raise `NotFoundError` for no shot's name."""
        if not _NAME.fullmatch(shot):
            raise NotFoundError("no such shot", value=repr(shot), todo="list the shots")
        return self._shots / shot.partition("-")[0] / shot

    def write(self, shot: str, frames: FrameSequence | None, manifest: Mapping[str, Any]) -> Path:
        """Write a shot's frames and manifest; return the folder once all of it is on disk.

        The folder is filled under another name, forced to disk, renamed, and its parent forced
        to disk. The manifest gains the entry `frames`, null where there are none. What `room`
        holds goes to the frames.

        Raises
        ------
        StoreError
            The shot's folder exists, or the disk refused; nothing is left behind.
        """
        target = self.folder(shot)
        partial = target.with_name(f".{shot}{PARTIAL}")
        with _store_errors(shot, target):
            if target.exists():
                raise FileExistsError(0, "the shot's folder exists already")
            make_folders(target.parent)
            try:
                partial.mkdir(FOLDER_MODE)
                if frames is not None:
                    self.room.become(partial / FRAMES)
                _fill(partial, frames, manifest)
                partial.rename(target)
                sync_folder(target.parent)
            finally:
                shutil.rmtree(partial, ignore_errors=True)
        return target

    def manifest(self, shot: str) -> dict[str, Any]:
        """Return a shot's manifest; raise `NotFoundError` where no frames were stored."""
        path = self.folder(shot) / "manifest.json"
        with _store_errors(shot, path):
            document: dict[str, Any] = json.loads(path.read_bytes())
        return document

    def days(self) -> list[Path]:
        """Return the folders in which shots lie, those of imports among them."""
        if not self._shots.is_dir():
            return []
        return sorted(p for p in self._shots.iterdir() if p.is_dir() and p.name[0] != ".")

    def digest(self, shot: str) -> str | None:
        """Return the SHA-256 of a shot's manifest; None where there is none."""
        return _digest(self.folder(shot) / "manifest.json")

    def result_digest(self, shot: str, number: int) -> str | None:
        """Return the SHA-256 of the file of a shot's result; None where there is none."""
        return _digest(self.folder(shot) / _result_name(number))

    def results(self, shot: str) -> dict[int, Path]:
        """Return the files of a shot's results by their numbers, in order."""
        return results_in(self.folder(shot))

    def frames(self, shot: str) -> FrameSequence:
        """Return a shot's frames, as they came from the source; `read_pixels` of an import.

        Raises
        ------
        NotFoundError
            No frames were stored.
        StoreError
            The frames are not those that the manifest's digest was taken of.
        """
        about = self.manifest(shot)["frames"]
        if about is None:
            raise NotFoundError("has no frames", part=f"shot {shot}", todo="see its poses")
        path = self.folder(shot) / about["file"]
        with _store_errors(shot, path):
            found = sha256(path)
            if found != about["sha256"]:
                raise StoreError(
                    "the frames on disk are not those that were recorded",
                    part=str(path),
                    value=f"sha256 {found[:12]}",
                    limit=f"sha256 {about['sha256'][:12]}",
                    todo="restore the folder from a backup",
                    shot=shot,
                )
            pixels = read_pixels(path)
        return FrameSequence(
            pixels=pixels,
            times_s=np.array(about["times_s"], dtype=np.float64),
            sequence=np.array(about["sequence"], dtype=np.int64),
            lost=tuple(about["lost"]),
            source=about["source"],
        )

    def is_whole(self, shot: str) -> bool:
        """Whether frames and manifest are there and the frames match their digest."""
        try:
            self.frames(shot)
        except (NotFoundError, StoreError):
            return False
        return True

    def add_result(self, shot: str, result: Mapping[str, Any] | bytes) -> int:
        """Write a result beside those there are; return its number, counted from 1.

        Parameters
        ----------
        result
            Itself, or its `result_text`.

        Raises
        ------
        NotFoundError
            No frames were stored.
        StoreError
            The disk refused, or the result holds a number that is not finite.
        """
        folder = self.folder(shot)
        partial = folder / f".result{PARTIAL}"
        with _store_errors(shot, folder):
            text = result if isinstance(result, bytes) else result_text(result)
            partial.unlink(missing_ok=True)
            try:
                write_synced(partial, lambda file: file.write(text))
                number = max(map(_number, _results(folder)), default=0) + 1
                # A link, unlike a rename, refuses to take the place of a file that is there.
                os.link(partial, folder / _result_name(number))
            finally:
                partial.unlink(missing_ok=True)
            sync_folder(folder)
        return number

    def result(self, shot: str, number: int | None = None) -> dict[str, Any]:
        """Return one result of a shot, the latest by default; `NotFoundError` if there is none."""
        folder = self.folder(shot)
        there = _results(folder)
        chosen = [path for path in there if number is None or _number(path) == number]
        if not chosen:
            raise NotFoundError(
                "has no such result", part=f"shot {shot}", todo="await its analysis"
            )
        with _store_errors(shot, chosen[-1]):
            document: dict[str, Any] = json.loads(chosen[-1].read_bytes())
        return document

    def remove_partial(self) -> int:
        """Remove what a killed writer left behind; return how many there were."""
        leftovers = list(self._leftovers())
        for path in leftovers:
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)
        return len(leftovers)

    def _leftovers(self) -> Iterator[Path]:
        """Give every half-written file and folder, without listing what lies in each shot's."""
        days = list(os.scandir(self._shots)) if self._shots.is_dir() else []
        for day in days:
            if _is_partial(day.name):
                yield Path(day.path)
            elif day.is_dir():
                for shot in os.scandir(day.path):
                    if _is_partial(shot.name):
                        yield Path(shot.path)
                    elif os.path.exists(begun := f"{shot.path}/.result{PARTIAL}"):
                        yield Path(begun)


def _is_partial(name: str) -> bool:
    return name.startswith(".") and name.endswith(PARTIAL)


def read_pixels(path: Path) -> NDArray[np.uint8]:
    """Return frames that are kept, to be shown: those of an import are rounded to 8 bits, grey.

    Raises
    ------
    ValueError, OSError
        They cannot be read.
    """
    return _recorded(path) if path.name == FRAMES else _imported(path).pixels


def read_light(path: Path) -> Grey:
    """Return frames that are kept, to be measured: grey levels of 0 to 255 with all their bits.

    Raises
    ------
    ValueError, OSError
        They cannot be read.
    """
    return _recorded(path) if path.name == FRAMES else _imported(path).light


def _recorded(path: Path) -> NDArray[np.uint8]:
    pixels: NDArray[np.uint8] = np.load(path, allow_pickle=False)
    return pixels


def _imported(path: Path) -> FrameStack:
    # Readers of images are loaded only where frames are no arrays.
    from analysis.balls.films.frames import read_frames  # noqa: PLC0415
    from analysis.errors import InputError  # noqa: PLC0415

    try:
        return read_frames(path)
    except InputError as error:
        raise ValueError(str(error)) from error


def result_text(result: Mapping[str, Any]) -> bytes:
    """Return a result as its file has it: JSON with a line for each field.

    To indent all of it takes three times as long.

    Raises
    ------
    ValueError
        It holds a number that is not finite.
    """
    fields = (f"{json.dumps(k)}: {json.dumps(v, allow_nan=False)}" for k, v in result.items())
    return "\n".join(("{", ",\n".join(fields), "}", "")).encode()


def _fill(folder: Path, frames: FrameSequence | None, manifest: Mapping[str, Any]) -> None:
    about = None if frames is None else _saved(folder, frames)
    text = json.dumps({**manifest, "frames": about}, allow_nan=False, indent=1).encode()
    write_synced(folder / "manifest.json", lambda file: file.write(text))
    sync_folder(folder)


def _saved(folder: Path, frames: FrameSequence) -> dict[str, Any]:
    """Write frames and return their entry in the manifest."""

    def save(file: BinaryIO) -> None:
        np.save(file, frames.pixels, allow_pickle=False)

    path = folder / FRAMES
    (write_over_synced if path.exists() else write_synced)(path, save)
    return {
        "file": FRAMES,
        "sha256": sha256(path),
        "shape": list(frames.pixels.shape),
        "dtype": str(frames.pixels.dtype),
        "times_s": frames.times_s.tolist(),
        "sequence": frames.sequence.tolist(),
        "lost": list(frames.lost),
        "source": frames.source,
    }


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file; of a folder, that of its files' names and digests."""
    if path.is_dir():
        files = sorted(file for file in path.rglob("*") if file.is_file())
        lines = [f"{file.relative_to(path).as_posix()} {sha256(file)}\n" for file in files]
        return hashlib.sha256("".join(lines).encode()).hexdigest()
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def results_in(folder: Path) -> dict[int, Path]:
    """Return the files of the results in a shot's folder by their numbers, in order."""
    return {_number(path): path for path in _results(folder)}


def _results(folder: Path) -> list[Path]:
    return sorted(folder.glob("result-*.json"), key=_number)


def _result_name(number: int) -> str:
    return f"result-{number:04d}.json"


def _digest(path: Path) -> str | None:
    try:
        return sha256(path)
    except FileNotFoundError:
        return None


def _number(path: Path) -> int:
    return int(path.stem.removeprefix("result-"))


@contextmanager
def _store_errors(shot: str, path: Path) -> Iterator[None]:
    try:
        yield
    except FileNotFoundError as error:
        raise NotFoundError(
            "has no stored frames", part=f"shot {shot}", todo="ask for the shot's state"
        ) from error
    except (OSError, ValueError) as error:
        what = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise StoreError(
            what, part=str(path), todo="free or repair the disk, then try again", shot=shot
        ) from error
