"""Contacts that last: worlds of several force laws, and effects hidden on top of them."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.poses import PoseData
from analysis.model.verdict.selection import explain
from benchmarks.discovery.campaigns import posed
from benchmarks.discovery.options import Options
from simulators.challenge.campaign import Noise, run_campaign
from simulators.challenge.force_choice import Forces
from simulators.challenge.nature import Nature

AIR, STATED_DRAG = 0.4, 0.42
RIG = Forces()
WORLDS: Mapping[str, Forces] = {
    "rig's own": RIG,
    "increments": Forces(drag="increment", stiffness_ratio=0.6, damping_ratio=0.1),
    "whole levers": Forces(stiffness_ratio=0.85, damping_ratio=0.03, whole_levers=True),
    "bristles, viscous": Forces(push="viscous", drag="bristles", stiffness_ratio=0.85),
    "linear spring": Forces(push="linear", stiffness_ratio=0.3, damping_ratio=0.1),
    "linear, increments": Forces(
        push="linear", drag="increment", duration_s=1.2e-4, stiffness_ratio=0.7
    ),
    "viscous, sticking": Forces(
        push="viscous", drag="damped-while-sticking", stiffness_ratio=0.4, damping_ratio=0.2
    ),
    "constant dashpot": Forces(push="hertz-dashpot", stiffness_ratio=0.5, damping_ratio=0.05),
    "soft": Forces(duration_s=4e-4, stiffness_ratio=0.25, damping_ratio=0.08),
}
PLAIN = Nature(forces=RIG, drag_coefficient=AIR)
HIDDEN: Mapping[str, Nature] = {
    "restitution-viscoelastic": replace(PLAIN, viscosity=1.0),
    "friction-drift": replace(PLAIN, friction_drift=0.3),
    "torsional-friction": replace(PLAIN, torsion_radius_m=0.0008),
    "mass-mismatch": replace(PLAIN, mass_difference=0.01),
    "camera-roll": replace(PLAIN, roll_rad=0.0175),
    "drag": replace(PLAIN, drag_coefficient=3 * AIR),
}
RIG_NOISE = Noise(centre_px=0.0075, rotation_rad=4e-4)
"""Of the photometric method."""


def run(options: Options) -> None:
    """Print what becomes of every world, and of every effect hidden in the rig's own."""
    print(f"{'world':24} {'hidden':26} chi2   left out  seconds  verdict")
    for seed in range(max(options.campaigns // 100, 1)):
        for name, forces in WORLDS.items():
            nature = Nature(forces=forces, drag_coefficient=AIR)
            tell(name, "", lasting_campaign(nature, 800 + seed, options.shots))
        for name, nature in HIDDEN.items():
            tell("rig's own", name, lasting_campaign(nature, 900 + seed, options.shots))


def lasting_campaign(nature: Nature, seed: int, shots: int) -> PoseData:
    """Return poses of a campaign in a world whose air is stated."""
    return replace(posed(run_campaign(nature, seed, shots=shots)), drag_coefficient=STATED_DRAG)


def tell(world: str, hidden: str, data: PoseData) -> None:
    """Print the verdict on a campaign in one line."""
    start = time.process_time()
    verdict = explain(data, CATALOGUE)
    took = time.process_time() - start
    print(
        f"{world:24} {hidden:26} {verdict.fit.chi2_per_dof:.3f}  {verdict.path[-1].error.value:.3f}"
        f"     {took:6.1f}   {verdict.verdict} {', '.join(verdict.effects)}",
        flush=True,
    )
