"""What a laboratory may hide in its contacts, and the law that its spheres then obey."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from simulators.challenge import encounter
from simulators.challenge.bodies import Bodies
from simulators.challenge.flight import acceleration
from simulators.challenge.launch import Settings, Touch
from simulators.challenge.nature import Nature
from simulators.challenge.pressing import Passage
from simulators.world.contact import Contact
from simulators.world.contact import Touch as Meeting
from simulators.world.description import Environment, Sphere
from simulators.world.rotation import turn
from simulators.world.state import Motion

Floats = NDArray[np.float64]

_USUAL_TEMPERATURE_C = 23.0
_KEEP_EVERY = 10


def contact_law(nature: Nature) -> Callable[[Meeting], Contact]:
    """Return what two of the rig's spheres do to each other in this nature."""
    accelerate = acceleration(Nature(), Bodies.of(Sphere(), nature), Environment())

    def strike(meeting: Meeting) -> Contact:
        touch = _touch(meeting)
        # Neither settings nor order matter to what acts in the contact alone.
        settings = Settings(np.zeros(1), np.zeros(1), np.full(1, _USUAL_TEMPERATURE_C))
        passage = encounter.collide(nature, settings, touch, accelerate)
        return _contact(meeting, touch, passage)

    return strike


def _touch(meeting: Meeting) -> Touch:
    a, b = meeting.motions
    apart = b.centre - a.centre
    return Touch(
        point=0.5 * (a.centre + b.centre)[None],
        normal=(apart / np.linalg.norm(apart))[None],
        velocity=np.stack([a.velocity, b.velocity])[None],
        spin=np.stack([a.spin, b.spin])[None],
    )


def _contact(meeting: Meeting, touch: Touch, passage: Passage) -> Contact:
    """Return a passage of one shot as the world tells it; between two times it runs straight."""
    last = len(passage.position) - 1
    kept = [*range(0, last, _KEEP_EVERY), last]
    since = passage.ends_s[0] * np.array(kept) / last
    places, turns = passage.position[kept, 0], passage.turned[kept, 0]
    steps = np.maximum(np.diff(since), np.finfo(float).tiny)[:, None, None]
    velocity = np.concatenate([np.diff(places, axis=0) / steps, passage.velocity])
    spin = np.concatenate([np.diff(turns, axis=0) / steps, passage.spin])
    velocity[0], spin[0] = touch.velocity[0], touch.spin[0]
    apart = places[:, 1] - places[:, 0]
    gaps = np.linalg.norm(apart, axis=1)
    return Contact(
        times_s=meeting.time_s + since,
        motions=tuple(
            (
                _motion(meeting.motions[0], places[k, 0], turns[k, 0], velocity[k, 0], spin[k, 0]),
                _motion(meeting.motions[1], places[k, 1], turns[k, 1], velocity[k, 1], spin[k, 1]),
            )
            for k in range(len(kept))
        ),
        normal=apart[0] / gaps[0],
        normal_after=apart[-1] / gaps[-1],
        compression_m=float(gaps[0] - gaps.min()),
    )


def _motion(
    at_touch: Motion, centre: Floats, turned: Floats, velocity: Floats, spin: Floats
) -> Motion:
    return Motion(centre, velocity, turn(turned, at_touch.orientation), spin)
