"""Where the markers of a fitted sphere stand in its frames."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled
from analysis.photometric.render.camera import Optics, axes_at, disc_of
from analysis.photometric.render.sight import Look

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


@compiled
def facing_markers(
    optics: Optics, look: Look, centres: Floats, rotations: Floats, least_facing: float
) -> tuple[Floats, Indices, Indices]:
    """Find the markers that face a view in each frame, view after view.

    Parameters
    ----------
    centres, rotations
        m and body to rig axes, shapes (frames, 3), (frames, 3, 3).
    least_facing
        Cosine to the line of sight of those that still do.

    Returns
    -------
    Row and column, semi-axes, angle and rms (0) of each ellipse, pixels, its direction in rig axes,
    and facing, shape (markers, 10); marker and view of each, shape (markers, 2); and the number up
    to the end of each frame, shape (frames,).
    """
    frames, views, most = centres.shape[0], optics.scales.shape[0], look.markers.shape[0]
    rows, count = np.zeros((frames * views * most, 10)), 0
    names, ends = np.zeros((frames * views * most, 2), dtype=np.intp), np.zeros(frames, np.intp)
    deep, wide, turned = math.cos(look.alpha), math.sin(look.alpha), np.zeros(3)
    for k in range(frames):
        for v in range(views):
            y, x, radius = disc_of(optics, v, centres[k], look.radius_m)
            axes = axes_at(optics, v, centres[k])
            for m in range(most):
                own = rows[count]
                for a in range(3):
                    own[6 + a], turned[a] = 0.0, 0.0
                for a in range(3):
                    for b in range(3):
                        own[6 + a] += rotations[k, a, b] * look.markers[m, b]
                for a in range(3):
                    for b in range(3):
                        turned[a] += axes[a, b] * own[6 + b]
                if turned[2] < least_facing:
                    continue
                own[0], own[1] = y + radius * deep * turned[0], x + radius * deep * turned[1]
                own[2], own[3] = radius * wide, radius * wide * turned[2]
                own[4], own[9] = math.atan2(turned[0], -turned[1]), turned[2]
                names[count, 0], names[count, 1] = m, v
                count += 1
        ends[k] = count
    return rows[:count].copy(), names[:count].copy(), ends
