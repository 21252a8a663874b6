"""One process owns a store at a time: a lock on a file in its folder."""

from __future__ import annotations

import errno
import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from rigctl.errors import StoreError
from rigctl.store.durable import FILE_MODE, FOLDER_MODE, make_folders


def own(folder: Path, *, shared: bool) -> int:
    """Return the descriptor that holds the store; -1 where another process does and may."""
    descriptor = -1
    try:
        make_folders(folder)
        descriptor = os.open(
            folder / "store.lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, FILE_MODE
        )
        _keep_to_owner(folder)
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if descriptor >= 0:
            os.close(descriptor)
        if shared and error.errno == errno.EWOULDBLOCK:
            return -1
        raise refused(folder, error) from error
    return descriptor


def _keep_to_owner(folder: Path) -> None:
    """Restrict the folder to its owner; a process of another user leaves its mode unchanged."""
    with suppress(PermissionError):
        folder.chmod(FOLDER_MODE)


@contextmanager
def owned(folder: Path) -> Iterator[None]:
    """Own a store for as long as the block runs.

    Raises
    ------
    StoreError
        Another process does, or the folder cannot be written.
    """
    descriptor = own(folder, shared=False)
    try:
        yield
    finally:
        os.close(descriptor)


def refused(folder: Path, error: OSError) -> StoreError:
    """Return the error of a folder that does not take what is written."""
    if error.errno == errno.EWOULDBLOCK:
        return owned_elsewhere(str(folder))
    return StoreError(
        f"cannot be written: {error.strerror or error}",
        part=str(folder),
        todo="free disk space or correct the folder's rights, then try again",
    )


def owned_elsewhere(part: str) -> StoreError:
    """Return the error of a store that another process owns."""
    return StoreError(
        "another process owns the store",
        part=part,
        todo="end the other daemon, or name another store folder",
    )
