"""How faults of the camera would change the image of a sphere, to first order."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.photometric.render.camera import BENT, Optics, by_nearness, disc_of, nearer

NEARNESS, MIRROR, ROLL, DISTORTION, SHIFT = range(5)
FAULTS = 5
"""Nearness of the camera, 1/m; turn of the mirror about Y, rad; roll of the camera against the
mirror, rad; radial distortion, share by which a corner lies too far out; columns by which the
origin of the mirror's view is shifted, px, of no interest by itself."""
ABOUT_Y = np.array([0.0, 1.0, 0.0])


def by_faults(optics: Optics, view: int, centre: Floats) -> Floats:
    """Return the change of a view of a sphere with each fault, shape (BENT, FAULTS).

    A mirror turned by d turns what it shows by 2 d about Y; a camera that rolls turns both images
    about the middle of the frame. Distortion by k r^2 moves an image outwards and enlarges it by
    3 k r^2 along the radius and k r^2 across it, 2 k r^2 in the mean.
    """
    change = np.zeros((BENT, FAULTS))
    change[:, [NEARNESS]] = by_nearness(optics, view, centre)
    row, column, _ = disc_of(optics, view, centre, 0.0)
    down, across = row - optics.middle[0], column - optics.middle[1]
    if view > 0:
        seen = optics.scales[view] * np.cross(ABOUT_Y, centre) / nearer(optics, view, centre)
        change[:2, MIRROR] = 2.0 * optics.axes[view, :2] @ seen
        change[2:5, MIRROR] = 2.0 * optics.hands[view] * optics.axes[view] @ ABOUT_Y
        change[1, SHIFT] = 1.0
    # From rows toward columns: x' = x - s y, y' = y + s x.
    change[:2, ROLL] = -across, down
    change[4, ROLL] = 1.0
    corner2 = optics.middle[0] ** 2 + optics.middle[1] ** 2
    share = (down**2 + across**2) / corner2
    change[:2, DISTORTION] = share * down, share * across
    change[BENT - 2 :, DISTORTION] = 2.0 * share
    return change
