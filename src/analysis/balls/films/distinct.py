"""A film that was brought to another rate, without the pictures that repeat the one before."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.films.film import Film, Picture


class DistinctFilm(Film):
    """The pictures of a film that are new, evenly spaced in the time that all of it lasts.

    Parameters
    ----------
    again
        Which frames show the picture before them, shape (frames,).
    share
        Pictures over frames in the rhythm in which they do.
    times_s
        Of the frames, s, evenly spaced.

    Attributes
    ----------
    times_s
        Of the pictures.
    note
        What a person should know of it.
    """

    def __init__(
        self, film: Film, again: NDArray[np.bool_], share: tuple[int, int], times_s: Floats
    ) -> None:
        self._film, self._again = film, again
        pictures, frames = share
        step_s = float(np.median(np.diff(times_s))) * frames / pictures
        self.times_s: Floats = np.asarray(step_s * np.arange(np.count_nonzero(~again)), np.float64)
        each = f"each {frames} frames show {pictures} picture{'s' * (pictures > 1)}"
        self.note = (
            f"the film was brought to another rate: {each}, frame {int(np.argmax(again))} is the "
            f"first that shows the one before it once more; its {np.count_nonzero(~again)} "
            f"pictures are measured as {1.0 / step_s:.5g} a second, evenly spaced, and frame "
            "numbers here count them (--fps states the rate of all frames)"
        )
        super().__init__(
            film.path,
            replace(
                film.head,
                frames=len(self.times_s),
                per_frame=film.head.per_frame * pictures / frames,
                times_s=None if film.head.times_s is None else self.times_s,
                rate_hz=1.0 / step_s,
            ),
        )

    def _read(self) -> Iterator[Picture]:
        for picture, again in zip(self._film.pictures(), self._again, strict=False):
            if not again:
                yield picture
