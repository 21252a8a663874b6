"""A slide that stops short on the side it comes from."""

from __future__ import annotations

from dataclasses import replace

from analysis.effects.effect import LaunchEffect, Parameter, Values
from analysis.launch.muzzle import Charge, Launcher, Muzzle


def wrap(launcher: Launcher, values: Values) -> Launcher:
    """Add half the backlash in the direction of the last move."""

    def changed(charge: Charge) -> Muzzle:
        moved = charge.offset_m + 0.5 * values[0] * charge.slide_step
        return launcher(replace(charge, offset_m=moved))

    return changed


EFFECT = LaunchEffect(
    name="slide-backlash",
    title="Backlash of the slide",
    parameters=(
        Parameter(
            symbol="B",
            unit="m",
            meaning="difference of offsets reached from above and from below",
            plausible=(-1e-4, 1e-4),
            step=1e-8,
        ),
    ),
    formula="offset' = offset + (B / 2) sign(last move); B < 0 where the slide lags",
    source="lead screws without preload: up to 0.1 mm",
    gives_away="the offset of the tracks at one setting follows the direction of the last move",
    confused_with=("launch-delay",),
    wrap=wrap,
)
