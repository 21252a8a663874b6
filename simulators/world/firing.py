"""What comes of a launch in a world, whatever apparatus it has."""

from __future__ import annotations

from functools import partial

import numpy as np

from simulators.world.bounces import drop
from simulators.world.contact import collide
from simulators.world.description import Magnet, WorldDescription
from simulators.world.encounter import Encounter, Law, simulate
from simulators.world.launch import Launch
from simulators.world.release import Release


def fire(
    description: WorldDescription,
    launch: Launch | Release,
    rng: np.random.Generator,
    law: Law | None = None,
) -> Encounter:
    """Follow the spheres of one launch; the arguments are those of `simulate`."""
    if isinstance(description.holder, Magnet):
        own = partial(collide, law=description.contact) if law is None else law
        return drop(description, description.holder, rng, own)
    return simulate(description, launch, rng, law)
