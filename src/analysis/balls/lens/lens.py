"""A lens as it was calibrated, its file lens.toml, and a film without its distortion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, cast

import cv2
import numpy as np
from pydantic import Field, ValidationError
from pydantic.dataclasses import dataclass

from analysis.arrays import Floats
from analysis.balls.films.film import Film, Picture
from analysis.errors import InputError
from analysis.exchange.faults import fault
from analysis.files import read_toml, toml_text
from analysis.schema.codec import STRICT, read, written
from analysis.setup import Pixel


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


FORMAT = 1
Length = Annotated[float, Field(gt=0, le=1e7)]
Coefficient = Annotated[float, Field(ge=-10, le=10)]
Sigma = Annotated[float, Field(ge=0)]


@dataclass(frozen=True, slots=True, config=STRICT)
class Lens:
    """Pinhole and radial distortion: D. C. Brown, Photogramm. Eng. 37, 855 (1971).

    A direction (x, y, 1) is seen at centre + focal (x, y) (1 + k1 r^2 + k2 r^4), r^2 = x^2 + y^2.

    Attributes
    ----------
    height_px, width_px
        Size of the pictures that it was calibrated with; it holds for no others.
    focal_px
        (along rows' direction, along columns' direction), that is (vertical, horizontal).
    centre_px
        Principal point, (row, column); an integer is the centre of a pixel.
    k1, k2
        Of the distortion.
    focal_sigma_px, k1_sigma, k2_sigma
        Standard errors.
    corner_px, corner_sigma_px
        How far distortion moves the corner of the picture that is farthest from the centre,
        outwards positive, and its standard error.
    """

    height_px: Annotated[int, Field(ge=8, le=65536)]
    width_px: Annotated[int, Field(ge=8, le=65536)]
    focal_px: tuple[Length, Length]
    centre_px: Pixel
    k1: Coefficient
    k2: Coefficient
    focal_sigma_px: Sigma
    k1_sigma: Sigma
    k2_sigma: Sigma
    corner_px: float
    corner_sigma_px: Sigma

    @property
    def matrix(self) -> Floats:
        """Return the camera matrix in the order (column, row, 1), shape (3, 3)."""
        (fy, fx), (row, column) = self.focal_px, self.centre_px
        return np.array([[fx, 0.0, column], [0.0, fy, row], [0.0, 0.0, 1.0]])

    @property
    def distortion(self) -> Floats:
        """Return k1, k2 and two zeros for decentring, shape (4,)."""
        return np.array([self.k1, self.k2, 0.0, 0.0])


def write_lens(path: Path, lens: Lens) -> None:
    """Write lens.toml."""
    path.write_text(toml_text({"format": FORMAT, **written(lens)}), encoding="utf-8")


def read_lens(path: Path) -> Lens:
    """Read lens.toml.

    Raises
    ------
    InputError
        Absent, not TOML, of a newer format, or every key that is unknown, missing or out of range.
    """
    table = read_toml(path)
    found = table.pop("format", None)
    if found != FORMAT:
        raise InputError(path, f"format {found!r}; this program reads format {FORMAT} of a lens")
    try:
        return read(Lens, table)
    except ValidationError as error:
        raise InputError(path, "; ".join(map(fault, error.errors()))) from error
