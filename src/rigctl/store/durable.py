"""Files that are whole or absent, whatever happens while they are written, and room for them."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from rigctl.errors import StoreError

FOLDER_MODE, FILE_MODE = 0o700, 0o600
"""What a store holds is its owner's alone, whatever the umask of who writes it."""


def sync_folder(folder: Path) -> None:
    """Force a folder's entries to disk: a rename survives a power cut only after this."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def create(path: Path) -> BinaryIO:
    """Open a file that must not exist to write, for its owner alone."""
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC
    return os.fdopen(os.open(path, flags, FILE_MODE), "wb")


def write_synced(path: Path, write: Callable[[BinaryIO], object]) -> None:
    """Create a file that must not exist, fill it, and force its content to disk."""
    with create(path) as file:
        write(file)
        file.flush()
        os.fsync(file.fileno())


def write_over_synced(path: Path, write: Callable[[BinaryIO], object]) -> None:
    """Fill a file from its beginning, cut what is left of it, and force its content to disk."""
    with path.open("r+b") as file:
        write(file)
        file.truncate()
        file.flush()
        os.fsync(file.fileno())


def make_folders(folder: Path) -> None:
    """Create a folder and those above it for their owner alone, each entry forced to disk."""
    missing = [place for place in (folder, *folder.parents) if not place.exists()]
    for place in reversed(missing):
        place.mkdir(FOLDER_MODE, exist_ok=True)
        sync_folder(place.parent)


def replace_synced(path: Path, content: bytes) -> None:
    """Write a file in the place of one that may be there, whole or not at all; forced to disk."""
    partial = path.with_name(f"{path.name}.partial")
    make_folders(path.parent)
    partial.unlink(missing_ok=True)
    write_synced(partial, lambda file: file.write(content))
    partial.replace(path)
    sync_folder(path.parent)


BESIDE_FRAMES = 1_000_000
"""Bytes held for what is written with the frames: their head and the manifest."""


class Room:
    """Room for the frames of one shot at a time, in a file below a folder."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / ".room.partial"

    def hold(self, size: int) -> None:
        """Hold room for frames of so many bytes, in the place of what was held before.

        Raises
        ------
        StoreError
            The disk has less; with the bytes needed and free. Nothing is held then.
        """
        needed = size + BESIDE_FRAMES
        self.give_back()
        try:
            make_folders(self._path.parent)
            flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC
            descriptor = os.open(self._path, flags, FILE_MODE)
            try:
                os.posix_fallocate(descriptor, 0, needed)
            finally:
                os.close(descriptor)
        except OSError as error:
            self.give_back()
            raise StoreError(
                f"room for the frames of a shot is not there: {error.strerror}",
                part=str(self._path.parent),
                value=f"{_free(self._path.parent)} bytes free",
                limit=f"at least {needed} bytes",
                todo="free disk space, then try again",
            ) from error

    def become(self, target: Path) -> None:
        """Give the room to a file that is written next; nothing happens where none is held."""
        if self._path.exists():
            self._path.rename(target)

    def give_back(self) -> None:
        """Free the room, where any is held. Never raises: a restart frees what is left."""
        try:
            self._path.unlink(missing_ok=True)
        except OSError:
            return


def _free(folder: Path) -> int:
    there = next(place for place in (folder, *folder.parents) if place.exists())
    return shutil.disk_usage(there).free
