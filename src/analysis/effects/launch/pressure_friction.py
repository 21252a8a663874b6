"""Friction of a pusher: pressure that moves nothing."""

from __future__ import annotations

from dataclasses import replace

from analysis.effects.effect import LaunchEffect, Parameter, Values
from analysis.launch.muzzle import Charge, Launcher, Muzzle


def wrap(launcher: Launcher, values: Values) -> Launcher:
    """Take the friction of each pusher off its pressure."""

    def changed(charge: Charge) -> Muzzle:
        return launcher(replace(charge, pressure_kpa=charge.pressure_kpa - values))

    return changed


def _of_pusher(name: str) -> Parameter:
    return Parameter(
        symbol=f"p_{name}",
        unit="kPa",
        meaning=f"pressure that just moves pusher {name} and its sphere",
        plausible=(0.0, 15.0),
        step=1e-4,
        one_sided=True,
    )


EFFECT = LaunchEffect(
    name="pressure-friction",
    title="Friction of the pusher",
    parameters=(_of_pusher("a"), _of_pusher("b")),
    formula="v = sqrt(2 A L (p - p_f) / m_eff)",
    source="work less losses is kinetic energy; seals take 0 to 30 % of 50 kPa",
    gives_away="the square of the speed against the pressure is a line that misses the origin",
    confused_with=("pressure-leak",),
    wrap=wrap,
)
