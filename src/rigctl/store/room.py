"""Room on the disk that is held before a shot fires, so that its frames can be kept whatever comes.

The file that holds it becomes the file of the frames: there is no moment at which the room is free
and the frames are not yet there. On file systems that never write in place (btrfs, ZFS) the kernel
holds the room as far as the file system lets it.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from rigctl.errors import StoreError
from rigctl.store.durable import FILE_MODE, make_folders

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
