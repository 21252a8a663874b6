"""Temporary files that find no room."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from tempfile import gettempdir

from rigctl.errors import StoreError


@contextmanager
def temporary_room(what: str = "poses") -> Iterator[None]:
    """Raise an error with the remedy where temporary files find no room.

    Parameters
    ----------
    what
        What they hold.

    Raises
    ------
    StoreError
        One cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise StoreError(
            f"{what} cannot be kept in a temporary file: {error.strerror or error}",
            part=gettempdir(),
            todo="free the disk, or name a folder with room in TMPDIR",
        ) from error
