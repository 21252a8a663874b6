"""Spin from rolling along the tube."""

from __future__ import annotations

from dataclasses import replace

from analysis.effects.effect import LaunchEffect, Parameter, Values
from analysis.launch.muzzle import ALONG, Charge, Launcher, Muzzle


def wrap(launcher: Launcher, values: Values) -> Launcher:
    """Add a share of the spin of a sphere that rolls on the floor of its tube.

    No slip at the lowest point, R along +X: v + omega x R = 0, so omega_z = -v_y / R.
    """

    def changed(charge: Charge) -> Muzzle:
        muzzle = launcher(charge)
        spin = muzzle.spin.copy()
        spin[..., 2] -= values[0] * muzzle.speed * ALONG / charge.radius_m
        return replace(muzzle, spin=spin)

    return changed


EFFECT = LaunchEffect(
    name="tube-spin",
    title="Spin from rolling in the tube",
    parameters=(
        Parameter(
            symbol="c",
            unit="1",
            meaning="spin in units of that of rolling",
            plausible=(0.0, 1.0),
            one_sided=True,
        ),
    ),
    formula="omega_z = -c v_y / R",
    source="kinematics of rolling; c = 1 without slip, less where the push is short",
    gives_away="spins about Z grow with the speed, of opposite sign in a and b",
    confused_with=("pressure-hysteresis",),
    wrap=wrap,
)
