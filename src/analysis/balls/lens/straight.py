"""A film with the distortion of its lens taken out of every picture."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import cast

import cv2

from analysis.balls.films.film import Film, Picture
from analysis.balls.lens.lens import Lens
from analysis.errors import InputError


class StraightFilm(Film):
    """Pictures as a pinhole of the lens's focal length and centre would have made them.

    Where a picture shows what the camera did not see, it is black.

    Raises
    ------
    InputError
        The lens was calibrated with pictures of another size.
    """

    def __init__(self, film: Film, lens: Lens) -> None:
        head = film.head
        if (head.height, head.width) != (lens.height_px, lens.width_px):
            raise InputError(
                film.path,
                f"its pictures have {head.width} x {head.height} pixels; the lens was calibrated "
                f"with {lens.width_px} x {lens.height_px}",
            )
        focal = 0.5 * sum(lens.focal_px), lens.focal_sigma_px
        super().__init__(film.path, replace(head, focal_px=focal, principal_px=lens.centre_px))
        self._film = film
        self._from = cv2.initUndistortRectifyMap(
            lens.matrix, lens.distortion, None, lens.matrix, (head.width, head.height), cv2.CV_32FC1
        )

    def _read(self) -> Iterator[Picture]:
        for picture in self._film.pictures():
            straight = cv2.remap(picture, *self._from, cv2.INTER_CUBIC)
            yield cast("Picture", straight.reshape(picture.shape))
