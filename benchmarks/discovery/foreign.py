"""Contacts of other sizes than those that the model was built with, and pairs of unlike spheres.

Prints the verdict, and each parameter's error over its stated one where the world has the fitted
force law. Harder, softer, stiffer across the normal than along it; masses of one to three.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from analysis.arrays import Floats
from analysis.collision.operator import Body
from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.poses import PoseData
from analysis.model.verdict.selection import Verdict, explain
from benchmarks.discovery.campaigns import FRAMES, posed
from benchmarks.discovery.lasting import AIR, RIG_NOISE, STATED_DRAG
from benchmarks.discovery.options import Options
from benchmarks.discovery.pulls import left_head_on
from simulators.challenge.campaign import FRAME_RATE_HZ, Noise, run_campaign
from simulators.challenge.force_choice import Forces
from simulators.challenge.nature import Nature
from simulators.challenge.unlike import Motion, Pair, contact, film

FIRST_SEED = 730_000
APART = 1000
"""Between the seeds of worlds: with one seed they share launches and noise, and so their pulls."""


@dataclass(frozen=True, slots=True)
class World:
    """A contact, and whether poses are as exact as the photometric method's."""

    nature: Nature
    filmed: bool = False


def _world(forces: Forces, restitution: float, friction: float, *, filmed: bool = False) -> World:
    nature = Nature(restitution=restitution, friction=friction, forces=forces, drag_coefficient=AIR)
    return World(nature, filmed)


STEEL = Forces(drag="increment", duration_s=5e-5, stiffness_ratio=1.1, damping_ratio=0.02)
RUBBER = Forces(duration_s=4e-4, stiffness_ratio=1.1, damping_ratio=0.12)
WORLDS: Mapping[str, World] = {
    "steel": _world(STEEL, 0.9, 0.15),
    "steel, filmed": _world(STEEL, 0.9, 0.15, filmed=True),
    "rubber": _world(RUBBER, 0.55, 0.3),
    "rubber, filmed": _world(RUBBER, 0.55, 0.3, filmed=True),
    "sticky": _world(
        Forces(drag="damped-while-sticking", duration_s=3e-4, stiffness_ratio=0.8), 0.62, 0.2
    ),
    "smooth": _world(Forces(duration_s=1e-4, stiffness_ratio=0.4), 0.95, 0.02),
}
PAIRS: Mapping[str, Pair] = {
    "one to three": Pair((0.0127, 0.0127), (1150.0, 3450.0), damping=0.05, stiffness_ratio=0.7),
    "small and heavy": Pair((0.0127, 0.006), (1150.0, 7800.0), duration_s=9e-5, friction=0.2),
}


def run(options: Options) -> None:
    """Print what becomes of every world."""
    print(f"{'world':20} chi2   left out  seconds  verdict, and pulls")
    for seed in range(FIRST_SEED, FIRST_SEED + max(options.campaigns // 100, 1)):
        for k, (name, world) in enumerate(WORLDS.items()):
            noise = RIG_NOISE if world.filmed else Noise()
            own = seed + APART * (1 + k)
            fired = run_campaign(world.nature, own, shots=options.shots, noise=noise)
            data = _stated(posed(fired), world)
            _tell(name, data, _truth(world.nature))
        for name, pair in PAIRS.items():
            _tell(name, pair_campaign(pair, seed, options.shots), _pair_truth(pair))


def _stated(data: PoseData, world: World) -> PoseData:
    data = replace(data, drag_coefficient=STATED_DRAG)
    if not world.filmed:
        return data
    per_px = float(data.position_sigma[0, 0, 0, 0]) / 0.03
    return replace(
        data,
        position_sigma=np.full_like(data.position_sigma, RIG_NOISE.centre_px * per_px),
        rotation_sigma=np.full_like(data.rotation_sigma, RIG_NOISE.rotation_rad),
    )


def _truth(nature: Nature) -> dict[str, float]:
    forces = nature.forces
    assert forces is not None
    return {
        "e": left_head_on(nature),
        "mu": nature.friction,
        "lasting-contact.t": forces.duration_s,
        "lasting-contact.kappa": forces.stiffness_ratio,
        "lasting-contact.zeta": forces.damping_ratio,
    }


def _pair_truth(pair: Pair) -> dict[str, float]:
    frontal = Motion(
        np.array([[0.0, -pair.radii_m[0], 0.0], [0.0, pair.radii_m[1], 0.0]]),
        np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]),
        np.zeros((2, 3)),
        (Rotation.identity(), Rotation.identity()),
    )
    parted, _ = contact(pair, frontal)
    return {
        "e": float(parted.velocities[1, 1] - parted.velocities[0, 1]) / 2.0,
        "mu": pair.friction,
        "lasting-contact.t": pair.duration_s,
        "lasting-contact.kappa": pair.stiffness_ratio,
        "lasting-contact.zeta": pair.tangential_damping,
    }


def pair_campaign(pair: Pair, seed: int, shots: int) -> PoseData:
    """Return poses of two unlike spheres that meet at 1 to 4 m/s, up to 0.8 of touching by."""
    rng = np.random.default_rng(seed)
    stated = posed(run_campaign(Nature(), seed, shots=shots))
    sigma, turn = 1e-5, 1e-3
    times = (np.arange(FRAMES) - FRAMES / 2 + rng.uniform(0.1, 0.7, (shots, 1))) / FRAME_RATE_HZ
    filmed = [film(pair, _meeting(pair, rng), own) for own in times]
    places = np.array([one for one, _ in filmed])
    turns = np.array([one for _, one in filmed])
    true = Rotation.from_quat(turns.reshape(-1, 4), scalar_first=True)
    seen = Rotation.from_rotvec(rng.normal(0.0, turn, (len(true), 3))) * true
    return replace(
        stated,
        times_s=times - times[:, :1],
        position=places + rng.normal(0.0, sigma, places.shape),
        position_sigma=np.full(places.shape, sigma),
        rotation=seen.as_matrix().reshape(*places.shape, 3),
        rotation_sigma=np.full(places.shape[:3], turn),
        bodies=(_body(pair, 0), _body(pair, 1)),
        air_density=0.0,
    )


def _body(pair: Pair, sphere: int) -> Body:
    return Body.sphere(2 * pair.radii_m[sphere], pair.densities_kg_per_m3[sphere], 0.4)


def _meeting(pair: Pair, rng: np.random.Generator) -> Motion:
    beside = rng.uniform(0.0, 0.8)
    around = Rotation.from_rotvec(rng.normal(0.0, 0.2, 3))
    n = around.apply([beside, np.sqrt(1.0 - beside**2), 0.0])
    speed = around.apply([0.0, rng.uniform(1.0, 4.0), 0.0])
    radii: Floats = np.array(pair.radii_m)
    return Motion(
        np.array([-radii[0] * n, radii[1] * n]),
        np.array([0.5 * speed, -0.5 * speed]),
        rng.normal(0.0, 20.0, (2, 3)),
        (Rotation.random(rng=rng), Rotation.random(rng=rng)),
    )


def _tell(world: str, data: PoseData, truth: Mapping[str, float]) -> None:
    start = time.process_time()
    verdict = explain(data, CATALOGUE)
    took = time.process_time() - start
    print(
        f"{world:20} {verdict.fit.chi2_per_dof:.3f}  {verdict.path[-1].error.value:.3f}     "
        f"{took:6.1f}   {verdict.verdict} {', '.join(verdict.effects)}: {_pulls(verdict, truth)}",
        flush=True,
    )


def _pulls(verdict: Verdict, truth: Mapping[str, float]) -> str:
    found = verdict.fit.parameters()
    return ", ".join(
        f"{name.split('.')[-1]} {found[name].value:.5g} "
        f"({(found[name].value - true) / found[name].sigma:+.1f})"
        for name, true in truth.items()
        if name in found
    )
