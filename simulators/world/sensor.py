"""What a sensor makes of light: noise of electrons, a bent response, dead rows, a full well."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor behind the lens.

    Parameters
    ----------
    dead_rows
        Rows of a full frame that show `dead_grey`, noise and all.
    full_grey
        Grey level at which a pixel is full.
    corner_light
        Share of the light that reaches a corner of the frame, falling with the square of the
        distance from the middle.
    """

    dead_rows: tuple[int, ...] = ()
    dead_grey: int = 0
    full_grey: int = 255
    corner_light: float = 1.0
    response: float = 1.0
    grey_per_electron: float = 0.0

    def reached(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the light (rows, columns) that passes the lens to a full frame."""
        if self.corner_light == 1.0:
            return light
        rows, columns = light.shape
        down, across = np.mgrid[-1.0 : 1.0 : rows * 1j, -1.0 : 1.0 : columns * 1j]
        fall = 1.0 - (1.0 - self.corner_light) * (down**2 + across**2) / 2.0
        return np.asarray(light * fall, dtype=np.float32)

    def grey(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the grey levels (rows, columns) that light makes, without noise."""
        if self.response == 1.0:
            return light
        full = np.float32(self.full_grey)
        bent = full * (np.maximum(light, np.float32(0)) / full) ** np.float32(self.response)
        return np.asarray(bent, dtype=np.float32)

    def noise_grey(self, grey: NDArray[np.float32], read_grey: float) -> NDArray[np.float32]:
        """Return each pixel's standard deviation (rows, columns), read noise and electrons."""
        electrons = self.grey_per_electron * np.maximum(grey, np.float32(0))
        return np.asarray(np.sqrt(np.float32(read_grey**2) + electrons), dtype=np.float32)

    def read(self, picture: NDArray[np.uint8], first_row: int) -> NDArray[np.uint8]:
        """Return the picture (rows, columns) as read; `first_row` is its place in a full frame."""
        dead = [row - first_row for row in self.dead_rows]
        read = np.minimum(picture, np.uint8(self.full_grey))
        read[[row for row in dead if 0 <= row < len(picture)]] = self.dead_grey
        return np.asarray(read, dtype=np.uint8)
