"""Errors of the impacts of single shots against the truth, over their stated ones."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np

from analysis.shot import MeasuredShot

GRAVITY = np.array([9.80665, 0.0, 0.0])
Judged = Sequence[tuple[MeasuredShot, dict[str, Any]]]


def impact_pulls(shots: Judged, too_long: float) -> dict[str, list[float]]:
    """Return pulls of velocities and spins by axis, and of v_n, v_s and e.

    The stated errors hold what all shots share: of velocities the scale and the drag of the air,
    which along Z, across the flight, do little.

    Parameters
    ----------
    too_long
        Share by which all measured lengths are too long; taken out of the velocities by axis.
    """
    found = defaultdict[str, list[float]](list)
    for shot, truth in shots:
        impact = shot.impact
        for k, side in enumerate(("before", "after")):
            state = impact.before if k == 0 else impact.after
            # Measured states are those at first touch, true ones those at parting.
            fallen = k * truth["contact_duration_s"] * GRAVITY
            moved = (state.velocity_a, state.velocity_b), (state.spin_a, state.spin_b)
            for i in (0, 1):
                off = moved[0][i] / (1.0 + too_long) + fallen - truth[f"velocity_{side}"][i]
                turned = moved[1][i] - truth[f"spin_{side}"][i]
                for axis, name in enumerate("XYZ"):
                    sigma = impact.state_sigma[k, [i, 2 + i], axis]
                    found[f"velocity {name}"].append(off[axis] / sigma[0])
                    found[f"spin {name}"].append(turned[axis] / sigma[1])
        found["e"].append((impact.e.value + truth["v_n_after"] / truth["v_n"]) / impact.e.sigma)
        for name in ("v_n", "v_s"):
            if (value := getattr(impact, name)) is not None:
                found[name].append((value.value - truth[name]) / value.sigma)
    return found
