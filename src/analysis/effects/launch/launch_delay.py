"""One pusher that starts later than its command."""

from __future__ import annotations

from dataclasses import replace

from analysis.effects.effect import LaunchEffect, Parameter, Values
from analysis.launch.muzzle import Charge, Launcher, Muzzle


def wrap(launcher: Launcher, values: Values) -> Launcher:
    """Let pusher b start later by the delay."""

    def changed(charge: Charge) -> Muzzle:
        return launcher(replace(charge, delay_s=charge.delay_s + values[0]))

    return changed


EFFECT = LaunchEffect(
    name="launch-delay",
    title="Difference of the valves' delays",
    parameters=(
        Parameter(
            symbol="t",
            unit="s",
            meaning="time by which pusher b starts later than its command says",
            plausible=(-2e-3, 2e-3),
            step=1e-7,
        ),
    ),
    formula="the point of contact moves by v t / 2 toward b, the offset by the fall in t",
    source="kinematics; solenoid valves open in some milliseconds, no two alike",
    gives_away="the point of contact moves toward b in proportion to the speed",
    confused_with=("pressure-hysteresis",),
    wrap=wrap,
)
