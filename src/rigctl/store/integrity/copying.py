"""Copies that are proved while they are made."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from rigctl.store.durable import create, make_folders

_CHUNK = 1 << 20


def copy_synced(source: Path, target: Path) -> str:
    """Copy a file to where none is, force it to disk, and return the SHA-256 of its content.

    Folders above the target are made.

    Raises
    ------
    OSError
        It cannot be read or written.
    """
    make_folders(target.parent)
    digest = hashlib.sha256()
    with source.open("rb") as read, create(target) as write:
        while chunk := read.read(_CHUNK):
            digest.update(chunk)
            write.write(chunk)
        write.flush()
        os.fsync(write.fileno())
    return digest.hexdigest()
