"""A film: what its file says of it, and its frames one after another."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from queue import Full, Queue
from threading import Event, Thread
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.films.kept import KeptPictures, has_room

Picture = NDArray[np.uint8] | NDArray[np.uint16]
Readout = Literal["rows", "columns", "global", "unknown"]

HELD_BYTES = 400e6
"""Films that take no more are held once they are read; larger ones go into a temporary file when
they are read again."""
MOST_SAMPLES, LEAST_SAMPLES = 45, 11
SAMPLED_BYTES = 150e6
"""Of the frames that show what stands still."""


@dataclass(frozen=True, slots=True, eq=False)
class FilmHead:
    """What a file says of its film.

    Attributes
    ----------
    frames, height, width, channels
        Numbers of each; three channels are blue, green, red.
    times_s
        Time of each frame counted from the first, shape (frames,); None: no times in the file.
    rate_hz
        Nominal frames a second; None: not in the file.
    exposure_s
        Time the shutter is open; None: not in the file.
    encoded
        Whether values follow a tone curve (sRGB) and not the light.
    compressed
        Whether a codec has altered the pixels.
    readout
        What a rolling shutter would read one after another.
    notes
        What about the file could not be checked, one sentence each.
    focal_px
        Focal length and its standard error, of a lens that was calibrated; None: not known.
    whole_px
        Rows and columns of the camera's picture that this is a part of; None: it is the whole.
    principal_px
        Principal point, (row, column) of this picture, which may lie outside a part; None: the
        whole picture's middle.
    steady
        Whether pictures were brought back to where the camera was in one of them.
    per_frame
        Pictures for each frame of the file: two fields, or fewer than one where frames repeat some.
    """

    frames: int
    height: int
    width: int
    channels: int
    times_s: Floats | None = None
    rate_hz: float | None = None
    exposure_s: float | None = None
    encoded: bool = False
    compressed: bool = False
    readout: Readout = "global"
    notes: tuple[str, ...] = ()
    focal_px: tuple[float, float] | None = None
    whole_px: tuple[int, int] | None = None
    principal_px: tuple[float, float] | None = None
    steady: bool = False
    per_frame: float = 1.0

    @property
    def frame_bytes(self) -> int:
        """Return how many bytes a picture of 8 bits has."""
        return self.height * self.width * self.channels

    @property
    def whole(self) -> tuple[int, int]:
        """Return rows and columns of the camera's whole picture."""
        return self.whole_px or (self.height, self.width)

    @property
    def principal(self) -> tuple[float, float]:
        """Return the principal point, (row, column); that of a whole picture is its middle."""
        return self.principal_px or (0.5 * (self.height - 1), 0.5 * (self.width - 1))


def spread_frames(frames: int, frame_bytes: int) -> list[int]:
    """Return the numbers of frames, evenly spread, that show what stands still."""
    most = int(min(MOST_SAMPLES, max(LEAST_SAMPLES, SAMPLED_BYTES / frame_bytes)))
    count = min(frames, most)
    return sorted({round(k) for k in np.linspace(0, frames - 1, count).tolist()})


class Film(ABC):
    """Frames of one film; pictures have the shape (rows, columns, channels).

    Attributes
    ----------
    path
        File or folder, named in refusals.
    head
        What it says of itself.
    """

    def __init__(self, path: Path, head: FilmHead) -> None:
        self.path, self.head = path, head
        self._held: list[Picture] | None = None
        self._kept: KeptPictures | None = None
        self._looked_through = False
        self._read_before: dict[int, Picture] = {}

    def pictures(self) -> Iterator[Picture]:
        """Give all frames in order; read once where memory has room, twice where a file has."""
        if self._held is not None:
            yield from self._held
            return
        if self._kept is not None:
            yield from self._kept.pictures()
            return
        head, held = self.head, []
        kept = KeptPictures(head.frames) if self._goes_into_file else None
        keep = True
        taken = 0
        for picture in ahead(self._read()):
            taken += picture.nbytes
            keep = keep and taken <= HELD_BYTES
            if keep:
                held.append(picture)
            else:
                held = []
            if kept is not None and not kept.add(picture):
                kept = None
            yield picture
        if keep and len(held) == head.frames:
            self._held = held
        elif kept is not None and kept.whole:
            self._kept = kept
        self._looked_through = True

    def chosen(self, frames: Sequence[int]) -> dict[int, Picture]:
        """Return some frames by their numbers; those that opening has read are handed on once."""
        wanted = set(frames)
        if wanted <= self._read_before.keys():
            return {k: self._read_before.pop(k) for k in sorted(wanted)}
        last = max(wanted, default=-1)
        # A film that is being kept is read to its end once and never again.
        to_its_end = (self.may_be_held and self._held is None) or self._goes_into_file
        found = {}
        for number, picture in enumerate(self.pictures()):
            if number in wanted:
                found[number] = picture
            if number >= last and not to_its_end:
                break
        return found

    @property
    def _goes_into_file(self) -> bool:
        """Return whether the next look at all frames keeps them in a temporary file."""
        again = self._looked_through and self._kept is None and not self.may_be_held
        return again and has_room(self.head.frames, self.head.frame_bytes)

    @property
    def may_be_held(self) -> bool:
        """Return whether all frames fit into memory, as far as the head says."""
        head = self.head
        return head.frames * head.frame_bytes <= HELD_BYTES

    @abstractmethod
    def _read(self) -> Iterator[Picture]:
        """Give all frames, read anew.

        Raises
        ------
        InputError
            A frame is damaged or unlike the first.
        """


class HeldFilm(Film):
    """Frames that are in memory already, grey, shape (frames, rows, columns)."""

    def __init__(self, path: Path, frames: NDArray[np.uint8]) -> None:
        count, height, width = frames.shape
        super().__init__(path, FilmHead(count, height, width, 1))
        self._frames = frames

    def _read(self) -> Iterator[Picture]:
        for frame in self._frames:
            yield frame[..., None]


AHEAD = 4
"""Pictures that are read while one is looked at."""


def ahead(pictures: Iterator[Picture]) -> Iterator[Picture]:
    """Give pictures that a thread of their own reads: decoders leave the interpreter free."""
    waiting: Queue[Picture | BaseException | None] = Queue(AHEAD)
    stopped = Event()

    def put(what: Picture | BaseException | None) -> bool:
        while not stopped.is_set():
            try:
                waiting.put(what, timeout=0.1)
            except Full:
                continue
            return True
        return False

    def read() -> None:
        try:
            for picture in pictures:
                if not put(picture):
                    return
            put(None)
        except BaseException as error:  # noqa: BLE001  (raised again where pictures are used)
            put(error)

    reader = Thread(target=read, daemon=True)
    reader.start()
    try:
        while (what := waiting.get()) is not None:
            if isinstance(what, BaseException):
                raise what
            yield what
    finally:
        stopped.set()
        reader.join()
