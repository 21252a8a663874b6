"""A charge that leaks between the setting of the pressure and the pulse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.effects.effect import LaunchEffect, Parameter, Values
from analysis.launch.muzzle import Charge, Launcher, Muzzle


def wrap(launcher: Launcher, values: Values) -> Launcher:
    """Let each pressure fall by exp(-k t) in the time waited."""

    def changed(charge: Charge) -> Muzzle:
        left = np.exp(-values[0] * charge.waited_s)[:, None]
        return launcher(replace(charge, pressure_kpa=charge.pressure_kpa * left))

    return changed


EFFECT = LaunchEffect(
    name="pressure-leak",
    title="Leak of the charge",
    parameters=(
        Parameter(
            symbol="k",
            unit="1/s",
            meaning="rate of the leak, one over its time constant",
            plausible=(0.0, 0.01),
            step=1e-8,
            one_sided=True,
        ),
    ),
    formula="p' = p exp(-k t), t from the charging to the pulse",
    source="laminar leak of a vessel at small gauge pressure: outflow in proportion to p",
    gives_away="speeds at one pressure fall with the time waited",
    confused_with=("pressure-friction", "pressure-hysteresis"),
    wrap=wrap,
)
