"""What it costs to take Z as constant instead of from the mirror: table 3.3 of the thesis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats, Grey
from analysis.collision.coefficients import Impact
from analysis.qualification.drop import Method
from analysis.setup import Setup
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot, analyse_shot

QUANTITIES = ("v_n", "v_n_after", "v_s", "v_s_after", "e")


@dataclass(frozen=True, slots=True, eq=False)
class BothWays:
    """One shot measured with the mirror, and from the front view alone."""

    measured_z: Impact
    constant_z: Impact

    def relative(self, name: str) -> float:
        """Return (constant - measured) / measured of one of QUANTITIES.

        That of v_s_after over v_s: it passes through zero where a contact begins to roll.
        """
        with_mirror = getattr(self.measured_z, name).value
        change = getattr(self.constant_z, name).value - with_mirror
        over = getattr(self.measured_z, "v_s" if name == "v_s_after" else name).value
        return float(change / over)


def measure_both_ways(
    frames: Grey, times_s: Floats, setup: Setup, method: Method
) -> BothWays | RefusedShot:
    """Measure one shot with the mirror and without.

    Parameters
    ----------
    frames, times_s
        As for `analyse_shot`.
    setup
        With a top view.

    Returns
    -------
    Both impacts, or the refusal of the first that cannot be measured.
    """
    camera = replace(setup.camera, top_view_rows=None, top_origin_px=None)
    options = AnalysisOptions(method=method)
    impacts = []
    for known in (setup, replace(setup, camera=camera)):
        shot = analyse_shot(frames, times_s, known, options)
        if not isinstance(shot, MeasuredShot):
            return shot
        if shot.impact.v_s is None:
            return RefusedShot("rotation", "too few orientations tell the spins", None)
        impacts.append(shot.impact)
    return BothWays(*impacts)


def typical_errors(shots: Sequence[BothWays]) -> dict[str, tuple[float, float]]:
    """Return median and largest absolute relative error of each of QUANTITIES."""
    errors = {name: np.abs([shot.relative(name) for shot in shots]) for name in QUANTITIES}
    return {name: (float(np.median(own)), float(own.max())) for name, own in errors.items()}
