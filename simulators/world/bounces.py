"""A sphere that falls on a plate and bounces until it is out of time or out of reach."""

from __future__ import annotations

from functools import partial

import numpy as np

from simulators.world.contact import Contact, Touch
from simulators.world.description import Magnet, WorldDescription
from simulators.world.encounter import Encounter, Law, Path, Stretch
from simulators.world.flight import acceleration, fall
from simulators.world.release import PLATE, let_go, plate_below
from simulators.world.state import Motion, Pose

LASTS_S = 1.0
"""How long a dropped sphere is followed."""
LEAST_SPEED_M_PER_S = 0.02
"""A slower sphere rests on the plate."""


def drop(
    description: WorldDescription, magnet: Magnet, rng: np.random.Generator, law: Law
) -> Encounter:
    """Let sphere a fall and bounce; times count from the switching of the magnet."""
    sphere, environment = description.sphere_a, description.environment
    time_s, motion = let_go(magnet, 0.0, rng)
    end_s = time_s + LASTS_S
    stretches: list[Stretch] = []
    contacts: list[Contact] = []
    while True:
        flight = fall(motion, sphere, (time_s, end_s), magnet.plate_m, environment)
        stretches.append(Stretch(time_s, partial(flight.pose, 0)))
        if flight.touch_s is None:
            break
        arriving = flight.at(flight.touch_s)[0]
        if arriving.velocity[0] < LEAST_SPEED_M_PER_S:
            stretches.append(Stretch(flight.touch_s, partial(_resting, arriving)))
            break
        pull = acceleration(arriving.velocity, sphere, environment)
        bodies = (arriving, plate_below(magnet, arriving.centre))
        contact = law(Touch(flight.touch_s, (sphere, PLATE), bodies, (pull, np.zeros(3))))
        contacts.append(contact)
        stretches.append(Stretch(contact.start_s, partial(contact.pose, 0)))
        time_s, motion = contact.end_s, contact.motions[-1][0]
    path = Path(tuple(stretches), end_s)
    return Encounter(path, Path(), contacts[0] if contacts else None, tuple(contacts[1:]))


def _resting(motion: Motion, _: float) -> Pose:
    return Pose(motion.centre, motion.orientation)
