"""Files that are whole or absent, whatever happens while they are written."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

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
