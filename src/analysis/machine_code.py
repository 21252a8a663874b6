"""Where compiled functions are kept, and until when.

The compiler's library takes a kept function for fresh while the file that defines it is unchanged.
Compiled functions have those they call, and constants of other files, built in: a fresh one here is
one whose whole room is unchanged.

Each is compiled by one process, however many wait for it. Two that compile the same function, one
with the functions it calls just compiled and one with them as kept, may round differently.
"""

from __future__ import annotations

import os
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from hashlib import sha256
from pathlib import Path

from numba.core import caching

from analysis.file_lock import try_lock

USES = b"from analysis.compiled import"
LONGEST_S, AGAIN_S = 600.0, 0.05
"""Wait for another process, after which it is compiled here too, and time between two looks."""


@cache
def sources() -> str:
    """Return a digest of every file in a folder of this package where functions are compiled."""
    package = Path(__file__).parent
    folders = {file.parent for file in package.rglob("*.py") if USES in file.read_bytes()}
    digest = sha256()
    for file in sorted(file for folder in folders for file in folder.glob("*.py")):
        digest.update(file.relative_to(package).as_posix().encode() + file.read_bytes())
    return digest.hexdigest()


_here = threading.RLock()
"""Taken before any lock on disk: the compiler's library compiles in one thread at a time."""


@contextmanager
def alone(function: str) -> Iterator[None]:
    """Compile a function while no other process compiles it.

    The functions that it calls are compiled within it, each under a lock of its own. As none calls
    itself by way of others, two processes never wait for each other.
    """
    # Where users have no numbers, each has a folder for temporary files of his own.
    user = os.getuid() if hasattr(os, "getuid") else "user"
    folder = Path(tempfile.gettempdir()) / f"rigctl-{user}-{sources()[:16]}"
    folder.mkdir(mode=0o700, exist_ok=True)
    with _here, (folder / function).open("a", encoding="utf-8") as file:
        _wait_for(file.fileno())
        yield


def _wait_for(file: int) -> None:
    """Take the lock, or go on without it after LONGEST_S; closing the file gives it back."""
    until = time.monotonic() + LONGEST_S
    while time.monotonic() < until and not try_lock(file):
        time.sleep(AGAIN_S)


class BesideSource(caching.InTreeCacheLocator):
    """In `__pycache__`, as long as the sources are what they were."""

    def get_source_stamp(self) -> str:
        """Return what a kept function is fresh by."""
        return sources()


class OfUser(caching.UserWideCacheLocator):
    """In the user's own folder, where the package's cannot be written."""

    def get_source_stamp(self) -> str:
        """Return what a kept function is fresh by."""
        return sources()


LOCATORS = ",".join(f"{__name__}.{kind.__name__}" for kind in (BesideSource, OfUser))
