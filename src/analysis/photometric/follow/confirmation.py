"""Whether the markers that a pose puts before the camera are there.

A rendering can fit most pixels with a wrong turn: few of them show markers. The markers themselves
cannot be wrong together. What a marker's middle is expected to swallow is what the blur, the smear
and the nearest pixel leave of it: of one with a radius of two blurs nearly all, of one with 1.6
pixels in an exposure of a pixel's motion two thirds.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled
from analysis.photometric.render.covers import caps_of, cover_of
from analysis.photometric.render.residual import LOOK, hidden, lit, shade
from analysis.photometric.render.sight import Reel, Sight, Stance, sight_at

LEAST_FACING = 0.45
LEAST_SHARE = 0.7
"""Of the darkness expected at the markers: a true pose shows 0.9 to 1.1 of it, a false one 0.3."""

LEAST_CONTRAST = 4.0
"""Darkness expected of a marker, over the noise: on the unlit side of a sphere nothing shows."""
LEAST_BORNE_OUT, LEAST_WEIGHT = 0.6, 3.0
"""Of the darkness expected at one marker over all frames: true ones show 0.9 and more. Weight of a
marker that can be doubted; one that looks straight into a view has 1 a frame."""


@compiled
def add_shown(sight: Sight, stance: Stance, least: float, markers: tuple[Floats, Floats]) -> int:
    """Add the darkness at the markers' middles, and how much of it counts; return how many face.

    A marker counts by the square of its cover, as its noise asks for.

    Parameters
    ----------
    least
        Least expected darkness over the noise that can confirm a marker.
    markers
        Of each marker the darkness that it shows as a share of what is expected, and the weight
        of that, added to, shapes (markers,).
    """
    shown, expected = markers
    scene, look = sight.scene, sight.look
    seen, count = np.zeros(LOOK), 0
    for view in range(sight.optics.scales.shape[0]):
        caps = caps_of(sight, stance, view)
        place, directions, rows = caps.places[0], caps.directions[0], sight.optics.rows[view]
        light = stance.lights[view]
        for m in range(directions.shape[0]):
            u, v, z = directions[m, 0], directions[m, 1], directions[m, 2]
            y, x = int(np.rint(place[0] + place[2] * u)), int(np.rint(place[1] + place[2] * v))
            if z < LEAST_FACING or y < max(rows[0], 0) or y >= rows[1]:
                continue
            if x < 0 or x >= scene.image.shape[1] or hidden(scene, y, x, sight.others[view]):
                continue
            shade(look.discs[view], look.surfaces[view], u, v, seen)
            plain = lit(seen, light)
            cover = cover_of(caps, m, y, x)
            dark = plain * look.darkness * cover
            if dark < least * scene.noise:
                continue
            # One bright spot must not undo many markers, nor one dark spot make up for them.
            part = min(max((plain - scene.image[y, x]) / max(dark, 1.0), -1.0), 1.5)
            shown[m] += part * (z * cover) ** 2
            expected[m] += (z * cover) ** 2
            count += 1
    return count


@compiled
def shown_share(sight: Sight, stance: Stance) -> tuple[float, int]:
    """Return the darkness at the markers' middles as a share of what is expected, and how many.

    1 where no marker faces a view.
    """
    markers = sight.look.markers.shape[0]
    shown, expected = np.zeros(markers), np.zeros(markers)
    count = add_shown(sight, stance, -np.inf, (shown, expected))
    return (shown.sum() / expected.sum() if expected.sum() > 0.0 else 1.0), count


@compiled
def shown_shares(reel: Reel, frames: NDArray[np.intp], shown: Floats) -> None:
    """Fill `shown_share` of some frames of a reel: share and number, shape (frames, 2)."""
    for n in range(frames.shape[0]):
        sight, stance = sight_at(reel, frames[n])
        shown[n, 0], shown[n, 1] = shown_share(sight, stance)


def borne_out(
    sights: Iterable[tuple[Sight, Stance]], markers: int, *, unseen: bool = True
) -> NDArray[np.bool_]:
    """Return which markers of a sphere its frames show; a shadow's edge may pass for one.

    Parameters
    ----------
    unseen
        Result for those that never face a view.

    Returns
    -------
    Shape (markers,).
    """
    shown, expected = np.zeros(markers), np.zeros(markers)
    for sight, stance in sights:
        add_shown(sight, stance, LEAST_CONTRAST, (shown, expected))
    doubtful = (expected >= LEAST_WEIGHT) & (shown < LEAST_BORNE_OUT * expected)
    return np.asarray(~doubtful & (unseen | (expected > 0.0)))


def confirmed(reel: Reel, frames: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Return for frames of a reel whether the markers are there; true where none is visible."""
    shown = np.empty((len(frames), 2))
    shown_shares(reel, frames, shown)
    return np.asarray(shown[:, 0] >= LEAST_SHARE)
