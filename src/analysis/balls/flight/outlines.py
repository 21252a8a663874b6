"""How large and how round a ball is seen on its way: it drifts, and a camera sees spheres aslant.

Changes are those to the outline with which its places were fitted, whose radius has an error too.

Away from the middle of the picture the outline of a sphere is an ellipse, longer towards the border
by half of the squared tangent of the angle to the line of sight.
"""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight import path


def outlines(values: Floats, seen: Floats) -> Floats:
    """Return relative changes of the half axes along rows and columns, shape (N, 2).

    Parameters
    ----------
    values
        Of `path`.
    seen
        Row, column, and distance in its value at the first contact, shape (N, 3).
    """
    tangents = (seen[:, :2] - values[path.PRINCIPAL]) / (2.0 * values[path.HALF])
    aslant = 0.5 * values[path.ASLANT] * tangents**2
    return np.asarray(1.0 / seen[:, 2:] - 1.0 + values[path.OUTLINE] + aslant)
