"""What pages need of a shot's folder to show its film, read once for all who look."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from rigctl.errors import NotFoundError
from rigctl.page.parts.shared_reading import read_once
from rigctl.page.shots.overlay import Overlays
from rigctl.store import ShotRecord, Store

Json = Mapping[str, Any]
KEPT = 64
LEAST_CONTRAST = 15
"""Grey levels by which the brightest thousandth of a frame stands out where a sphere is seen; noise
alone reaches half of it."""
EVERY = 4
"""Rows and columns of which one tells how bright a frame is: a sphere covers dozens."""
FEW = ("poses", "overlay")
"""Parts of a result that are large, and that no table shows."""


@dataclass(frozen=True, slots=True)
class Film:
    """The film of a shot with what was found in it.

    Attributes
    ----------
    size
        Columns and rows of a frame.
    times_s
        Time of each frame from the mark, s.
    brightest
        Frame in which most is seen: where a film without a contact begins.
    blank
        Whether nothing stands out even there.
    overlays
        What the analysis found.
    """

    size: tuple[int, int]
    times_s: tuple[float, ...]
    brightest: int
    blank: bool
    overlays: Overlays


class Films:
    """Films and results of the shots looked at last. Any thread may call it."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._read = lru_cache(maxsize=KEPT)(self._read_result)
        self._seen = read_once(self._look, KEPT)

    def result(self, shot: ShotRecord) -> Json:
        """Return the latest result but for its poses and drawings; empty while there is none."""
        return self._read(shot.id, shot.results)[0] if shot.results else {}

    def earlier(self, shot: ShotRecord) -> Json:
        """Return the result before the latest one, likewise; empty where there is none."""
        return self._read(shot.id, shot.results - 1)[0] if shot.results > 1 else {}

    def film(self, shot: ShotRecord) -> Film:
        """Return the film of a shot that has frames.

        Raises
        ------
        RigError
            Its folder cannot be read.
        """
        size, times_s, brightest, blank = self._seen(shot.id)
        found = self._read(shot.id, shot.results)[1] if shot.results else Overlays.of({})
        return Film(size, times_s, brightest, blank, found)

    def _read_result(self, shot: str, number: int) -> tuple[Json, Overlays]:
        try:
            result = self._store.result(shot, number)
        except NotFoundError:
            return {}, Overlays.of({})
        small = {name: value for name, value in result.items() if name not in FEW}
        return small, Overlays.of(result)

    def _look(self, shot: str) -> tuple[tuple[int, int], tuple[float, ...], int, bool]:
        about = self._store.folders.manifest(shot)["frames"]
        _, rows, columns = about["shape"]
        pixels = self._store.frames(shot).pixels
        brightest = int(pixels[:, ::EVERY, ::EVERY].mean(axis=(1, 2)).argmax())
        middle, bright = np.percentile(pixels[brightest], (50.0, 99.9))
        blank = bool(bright - middle < LEAST_CONTRAST)
        return (columns, rows), tuple(about["times_s"]), brightest, blank
