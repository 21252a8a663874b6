"""Pictures of a board through a lens that is known: each pixel's ray is followed to the board."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Grey = NDArray[np.uint8]

FINE = 3
"""Rays a pixel each way."""


@dataclass(frozen=True)
class TrueLens:
    """Focal length, centre (row, column) in px, and distortion."""

    height: int = 300
    width: int = 400
    focal: float = 380.0
    centre: tuple[float, float] = (146.0, 207.0)
    k1: float = -0.25
    k2: float = 0.05

    def rays(self, rows: Floats, columns: Floats) -> tuple[Floats, Floats]:
        """Return the directions (x, y, 1) that are seen at places, by iteration."""
        x = seen_x = (columns - self.centre[1]) / self.focal
        y = seen_y = (rows - self.centre[0]) / self.focal
        for _ in range(30):
            square = x * x + y * y
            swell = 1 + self.k1 * square + self.k2 * square * square
            x, y = seen_x / swell, seen_y / swell
        return x, y

    def seen(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return (row, column) where directions are seen."""
        square = x * x + y * y
        swell = 1 + self.k1 * square + self.k2 * square * square
        return self.centre[0] + self.focal * y * swell, self.centre[1] + self.focal * x * swell


def chessboard(columns: int, rows: int, square_px: int = 40) -> Grey:
    """Return a board of so many inner corners, with a light rim one square wide."""
    r, c = np.mgrid[: (rows + 3) * square_px, : (columns + 3) * square_px] // square_px
    dark = ((r + c) % 2 == 0) & (r > 0) & (c > 0) & (r < rows + 2) & (c < columns + 2)
    return np.where(dark, 30, 220).astype(np.uint8)


def charuco(columns: int, rows: int, kind: int, square_px: int = 40) -> Grey:
    """Return a ChArUco board of so many inner corners, with a rim of one square."""
    dictionary = cv2.aruco.getPredefinedDictionary(kind)
    board = cv2.aruco.CharucoBoard((columns + 1, rows + 1), 1.0, 0.7, dictionary)
    size = (columns + 3) * square_px, (rows + 3) * square_px
    return np.asarray(board.generateImage(size, marginSize=square_px))


@cache
def _fine_rays(lens: TrueLens) -> Floats:
    """Return the directions that are seen in a picture, FINE each way, shape (rows, columns, 3)."""
    size = lens.height * FINE, lens.width * FINE
    rows, columns = (np.mgrid[: size[0], : size[1]] + 0.5) / FINE - 0.5
    x, y = lens.rays(rows, columns)
    return np.stack([x, y, np.ones_like(x)], axis=-1)


def filmed(lens: TrueLens, texture: Grey, square_m: float, view: int, square_px: int = 40) -> Grey:
    """Return the picture of a board held at one of many angles, with noise."""
    rng = np.random.default_rng(view)
    turn, _ = cv2.Rodrigues(rng.uniform(-1, 1, 3) * (0.6, 0.6, 0.15))
    middle = np.array([texture.shape[1], texture.shape[0]]) / square_px * square_m / 2
    place = np.array([*rng.uniform(-0.05, 0.05, 2), rng.uniform(0.24, 0.34)])
    rays = _fine_rays(lens)
    # Ray t d meets the board's plane n . (p - place) = 0.
    depth = (turn[:, 2] @ place) / (rays @ turn[:, 2])
    on_board = (rays * depth[..., None] - place) @ turn[:, :2] + middle
    pixel = on_board / square_m * square_px - 0.5
    light = cv2.remap(
        texture.astype(np.float32),
        pixel[..., 0].astype(np.float32),
        pixel[..., 1].astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=120.0,
    )
    small = light.reshape(lens.height, FINE, lens.width, FINE).mean(axis=(1, 3))
    noisy = small + rng.normal(0, 1.5, small.shape)
    return np.asarray(np.clip(noisy, 0, 255), np.uint8)
