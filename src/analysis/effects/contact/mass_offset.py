"""A centre of mass that is not the centre of the sphere."""

from __future__ import annotations

from analysis.arrays import Floats
from analysis.effects.effect import BodyEffect, Parameter, Turning, Values


def displace(turning: Turning, values: Values) -> Floats:
    """Return where the outlines' centres are seen.

    The centre of mass flies free; the outline's centre stands off it by R(t) c, c fixed in the
    body. At first touch it is the outlines that touch, so the paths are counted from there:
    x = x_m + (R(t) - R(touch)) c. What the lever arm c changes of the impulse, of the order c over
    the radius, is left out.
    """
    offset = values.reshape(2, 3, 1)
    turned = turning.rotation - turning.at_touch[:, None]
    return turning.position + (turned @ offset)[..., 0]


def _component(sphere: str, axis: str) -> Parameter:
    return Parameter(
        symbol=f"c_{sphere}{axis}",
        unit="m",
        meaning=f"centre of sphere {sphere} from its centre of mass, along its body axis {axis}",
        plausible=(-2e-4, 2e-4),
        step=1e-7,
    )


EFFECT = BodyEffect(
    name="mass-offset",
    title="Centre of mass off the centre",
    parameters=tuple(_component(sphere, axis) for sphere in "ab" for axis in "xyz"),
    formula="centre seen = centre of mass + R(t) c; it circles with the spin, at the speed omega c",
    source=(
        "kinematics of a rigid body; a void or a filled marker hole of 1 % of the mass at half the "
        "radius makes c = 0.06 mm"
    ),
    gives_away="tracks wobble about straight flight with the period of the spin, 2 pi / omega",
    confused_with=("exposure-offset", "radius-mismatch"),
    displace=displace,
)
