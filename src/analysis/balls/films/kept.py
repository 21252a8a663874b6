"""Pictures of a film that is too large for memory, in a temporary file from its second look on.

To decode a picture of 1920 x 1080 pixels of ten bits takes a tenth of a second, to read it from a
file that was just written a hundredth of that. To write it takes longer than to decode one of
eight bits, and most films are looked through once.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from tempfile import TemporaryFile, gettempdir
from typing import TYPE_CHECKING, cast
from weakref import finalize

import numpy as np

if TYPE_CHECKING:
    from analysis.balls.films.film import Picture

MOST_BYTES, ROOM = 8e9, 4.0
"""Of a film that is kept; and the free room of the temporary folder, in sizes of the film."""


def has_room(frames: int, frame_bytes: int) -> bool:
    """Return whether the temporary folder has room for the pictures of a film."""
    whole = float(frames) * frame_bytes
    try:
        return whole <= MOST_BYTES and ROOM * whole <= shutil.disk_usage(gettempdir()).free
    except OSError:
        return False


class KeptPictures:
    """Pictures of one shape in a file without a name, which ends with the program.

    Parameters
    ----------
    frames
        How many there will be.

    Raises
    ------
    OSError
        No file can be made in the temporary folder.
    """

    def __init__(self, frames: int) -> None:
        self._frames, self._written = frames, 0
        self._like = np.empty(0, np.uint8)
        self._file = TemporaryFile(buffering=0)  # noqa: SIM115
        finalize(self, self._file.close)

    @property
    def whole(self) -> bool:
        """Return whether all pictures are here."""
        return self._written == self._frames

    def add(self, picture: Picture) -> bool:
        """Append a picture; return whether there was room for it."""
        own = np.ascontiguousarray(picture)
        try:
            written = self._file.write(own.data.cast("B"))
        except OSError:
            return False
        self._like, self._written = np.empty_like(own), self._written + 1
        return written == own.nbytes

    def pictures(self) -> Iterator[Picture]:
        """Give all pictures in order."""
        for number in range(self._frames):
            picture = np.empty_like(self._like)
            self._file.seek(number * picture.nbytes)
            self._file.readinto(picture.data.cast("B"))
            yield cast("Picture", picture)
