"""A regulator that stops short on the side it comes from."""

from __future__ import annotations

from dataclasses import replace

from analysis.effects.effect import LaunchEffect, Parameter, Values
from analysis.launch.muzzle import Charge, Launcher, Muzzle


def wrap(launcher: Launcher, values: Values) -> Launcher:
    """Scale each speed by 1 + h times the sign of the last step of its pressure."""

    def changed(charge: Charge) -> Muzzle:
        muzzle = launcher(charge)
        return replace(muzzle, speed=muzzle.speed * (1.0 + values[0] * charge.pressure_step))

    return changed


EFFECT = LaunchEffect(
    name="pressure-hysteresis",
    title="Hysteresis of the regulator",
    parameters=(
        Parameter(
            symbol="h",
            unit="1",
            meaning="relative excess of speed after a step up, and lack after a step down",
            plausible=(-0.03, 0.03),
        ),
    ),
    formula="v' = v (1 + h s), s = +1 after a rise of the pressure, -1 after a fall",
    source="diaphragm and sensor of a regulator; 0 to 3 % of the speed are plausible",
    gives_away="speeds at one pressure fall into two groups by the pressure of the shot before",
    confused_with=("pressure-friction", "pressure-leak"),
    wrap=wrap,
)
