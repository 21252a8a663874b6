"""The pixels of a disc's patch on the way to its dark places, compiled (`dark_places`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey
from analysis.compiled import compiled

Singles = NDArray[np.float32]

LEAST_SHARE = 1e-3
"""Of smoothing that falls on free pixels; divided by no less."""


@compiled
def free_light(
    frame: Grey, corner: tuple[int, int], discs: Floats, free: Singles, light: Singles
) -> bool:
    """Mark the free pixels of a patch and take their light; tell whether there are any.

    Parameters
    ----------
    corner
        Row and column of the patch's first pixel in the frame.
    discs
        Row, column and radius: free is what lies in the first and in none of the others.
    free, light
        Filled with 1 or 0, and with grey levels or 0, shape (rows, columns).
    """
    some = False
    for i in range(free.shape[0]):
        for j in range(free.shape[1]):
            y, x, own = corner[0] + i, corner[1] + j, True
            for n in range(discs.shape[0]):
                d_r, d_c = y - discs[n, 0], x - discs[n, 1]
                own = own and (d_r * d_r + d_c * d_c < discs[n, 2] * discs[n, 2]) == (n == 0)
            free[i, j] = 1.0 if own else 0.0
            light[i, j] = frame[y, x] if own else 0.0
            some = some or own
    return some


@compiled
def over_share(light: Singles, share: Singles, free: Singles) -> None:
    """Divide smoothed light by the share of it that free pixels have; 0 where none is."""
    for i in range(light.shape[0]):
        for j in range(light.shape[1]):
            level = light[i, j] / max(share[i, j], np.float32(LEAST_SHARE))
            light[i, j] = level if free[i, j] > 0.0 else np.float32(0.0)


@compiled
def lacking(
    surface: Singles,
    smooth: Singles,
    free: Singles,
    least: tuple[float, float],
    dark: NDArray[np.uint8],
) -> None:
    """Leave of a closed surface what it lies above the light, where that is enough; else 0.

    Parameters
    ----------
    least
        Share of the surface, and grey levels.
    dark
        Filled with 1 where it is.
    """
    for i in range(surface.shape[0]):
        for j in range(surface.shape[1]):
            lack = surface[i, j] - smooth[i, j]
            enough = free[i, j] > 0.0 and lack > max(least[0] * surface[i, j], least[1])
            dark[i, j] = 1 if enough else 0
            surface[i, j] = lack if enough else np.float32(0.0)


@compiled
def weigh_places(missing: Singles, names: NDArray[np.int32], count: int) -> Floats:
    """Return size, missing light, and its mean row and column of each named place.

    Parameters
    ----------
    names
        Of each pixel's place, 0 for none.
    count
        Of names, with 0.

    Returns
    -------
    Shape (count, 4).
    """
    places = np.zeros((count, 4))
    for i in range(names.shape[0]):
        for j in range(names.shape[1]):
            own = places[names[i, j]]
            own[0] += 1.0
            own[1] += missing[i, j]
            own[2] += missing[i, j] * i
            own[3] += missing[i, j] * j
    for n in range(1, count):
        places[n, 2] /= places[n, 1]
        places[n, 3] /= places[n, 1]
    return places
