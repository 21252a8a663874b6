"""Copies that are proved while they are made."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

_CHUNK = 1 << 20


def copy_synced(source: Path, target: Path) -> str:
    """Copy a file to where none is, force it to disk, and return the SHA-256 of its content.

    Folders above the target are made.

    Raises
    ------
    OSError
        It cannot be read or written.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    digest = hashlib.sha256()
    with source.open("rb") as read, target.open("xb") as write:
        while chunk := read.read(_CHUNK):
            digest.update(chunk)
            write.write(chunk)
        write.flush()
        os.fsync(write.fileno())
    return digest.hexdigest()
