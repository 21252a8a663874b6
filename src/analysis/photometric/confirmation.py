"""Whether the markers that a pose puts before the camera are there.

A rendering can fit most pixels with a wrong turn: few of them show markers. The markers themselves
cannot be wrong together.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled
from analysis.photometric.camera import disc_of
from analysis.photometric.covers import seen_from
from analysis.photometric.residual import LOOK, hidden, lit, shade
from analysis.photometric.sight import Sight, Stance

Floats = NDArray[np.float64]

LEAST_FACING = 0.45
LEAST_SHARE = 0.7
"""Of the darkness expected at the markers: a true pose shows 0.9 to 1.1 of it, a false one 0.3."""


@compiled
def shown_share(sight: Sight, stance: Stance) -> tuple[float, int]:
    """Return the darkness at the markers' middles as a share of what is expected, and how many.

    1 where no marker faces a view.
    """
    scene, look = sight.scene, sight.look
    seen = np.zeros(LOOK)
    shown, expected, count = 0.0, 0.0, 0
    for view in range(sight.optics.scales.shape[0]):
        place = disc_of(sight.optics, view, stance.centre, look.radius_m)
        directions, rows = seen_from(sight, stance, view), sight.optics.rows[view]
        light = stance.lights[view]
        for m in range(directions.shape[0]):
            u, v, z = directions[m, 0], directions[m, 1], directions[m, 2]
            y, x = int(np.rint(place[0] + place[2] * u)), int(np.rint(place[1] + place[2] * v))
            if z < LEAST_FACING or y < max(rows[0], 0) or y >= rows[1]:
                continue
            if x < 0 or x >= scene.image.shape[1] or hidden(y, x, sight.others[view]):
                continue
            shade(look.discs[view], look.surfaces[view], u, v, seen)
            plain = lit(seen, light)
            # One bright spot must not undo many markers, nor one dark spot make up for them.
            part = min(
                max((plain - scene.image[y, x]) / max(plain * look.darkness, 1.0), -1.0), 1.5
            )
            shown += part * z * z
            expected += z * z
            count += 1
    return (shown / expected if count else 1.0), count


def confirmed(sight: Sight, stance: Stance) -> bool:
    """Tell whether the markers of a pose are there; true where none can be seen."""
    share, _ = shown_share(sight, stance)
    return bool(share >= LEAST_SHARE)
