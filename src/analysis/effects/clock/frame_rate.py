"""A camera whose true frame rate is not the stated one."""

from __future__ import annotations

from analysis.arrays import Floats
from analysis.effects.effect import ClockEffect, Exposure, Parameter, Values
from analysis.setup import CameraSetup


def expose(exposure: Exposure, camera: CameraSetup, values: Values) -> tuple[Floats, Floats]:
    """Return true times (1 + r) t, for positions and orientations alike."""
    del camera
    true = (1.0 + values[0]) * exposure.times_s[..., None]
    return true[..., None], true


EFFECT = ClockEffect(
    name="frame-rate",
    title="Frame rate",
    parameters=(
        Parameter(
            symbol="r",
            unit="1",
            meaning="share by which frames are further apart than stated",
            plausible=(-0.003, 0.003),
        ),
    ),
    formula="t_true = (1 + r) t",
    source="tape speed and crystal tolerance of the recorder (thesis, appendix A)",
    gives_away="the fall under gravity by 2 r; velocities and spins by r, which nothing else holds",
    confused_with=("gravity-value",),
    expose=expose,
)
