"""The way of both spheres through a shot: flight, contact, flight."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from simulators.challenge.bodies import Bodies
from simulators.challenge.coefficients import Coefficients, coefficients
from simulators.challenge.flight import Acceleration, acceleration, fly
from simulators.challenge.forces import press_by
from simulators.challenge.impact import grip, strike, twist
from simulators.challenge.launch import Settings, Touch
from simulators.challenge.nature import Nature
from simulators.challenge.pressing import Passage, press
from simulators.world.description import Environment, Sphere

Floats = NDArray[np.float64]

ACROSS = "impulse_t"
"""Slot of a law by which the impulse across the normal changes, whether spheres stick or slide."""

_SIDES = np.array([-1.0, 1.0])[:, None]


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """Both spheres in F frames of S shots, as they really are.

    Parameters
    ----------
    centres
        m, rig axes, (S, F, 2, 3).
    in_contact, in_flight
        Rotation vectors since first touch, rad, (S, F, 2, 3): first the one, then the other.
    """

    centres: Floats
    in_contact: Floats
    in_flight: Floats


def follow(nature: Nature, settings: Settings, touch: Touch, since_s: Floats) -> Way:
    """Follow both spheres to the true times of the frames since first touch (S, F), s.

    The first half of the frames comes before the touch, the other half after.
    """
    sphere = Sphere()
    bodies = Bodies.of(sphere, nature)
    accelerate = acceleration(nature, bodies, Environment())
    middle = since_s.shape[1] // 2
    before, after = since_s[:, :middle], since_s[:, middle:]
    passage = collide(nature, settings, touch, accelerate)
    incoming = fly((passage.position[0], touch.velocity, touch.spin), before[:, ::-1], accelerate)
    free = np.maximum(after - passage.ends_s[:, None], 0.0)
    outgoing = fly((passage.position[-1], passage.velocity, passage.spin), free, accelerate)
    pressed = (free == 0.0)[..., None, None]
    still = np.zeros((*before.shape, 2, 3))
    return Way(
        np.concatenate(
            [incoming[:, ::-1], np.where(pressed, passage.at(passage.position, after), outgoing)],
            axis=1,
        ),
        np.concatenate([still, passage.at(passage.turned, after)], axis=1),
        np.concatenate(
            [
                touch.spin[:, None] * before[..., None, None],
                passage.spin[:, None] * free[..., None, None],
            ],
            axis=1,
        ),
    )


def collide(nature: Nature, settings: Settings, touch: Touch, accelerate: Acceleration) -> Passage:
    """Return the contact of every shot: all at once, or in its time where nature is soft."""
    sphere = Sphere()
    bodies = Bodies.of(sphere, nature)
    held = coefficients(nature, settings, touch, sphere.radius_m)
    if nature.forces is not None:
        passage = press_by(nature.forces, touch, held, bodies, accelerate)
        return _twisted(nature, touch, held, passage, bodies)
    ratio = grip(nature, touch, held, bodies)
    if nature.dependence is not None:
        ratio = ratio * nature.dependence.factor(ACROSS, settings, touch, sphere.radius_m)
    if nature.softness > 0.0:
        softness = nature.softness
        passage = press(touch, held, ratio, bodies, softness=softness, outer=accelerate)
    else:
        velocity, spin = strike(touch, held, ratio, bodies)
        place = touch.point[:, None] + bodies.radius_m * _SIDES * touch.normal[:, None]
        unmoved = np.broadcast_to(place, (2, *place.shape))
        ends = np.zeros(len(place))
        passage = Passage(ends, unmoved, np.zeros_like(unmoved), velocity, spin)
    return _twisted(nature, touch, held, passage, bodies)


def _twisted(
    nature: Nature, touch: Touch, held: Coefficients, passage: Passage, bodies: Bodies
) -> Passage:
    if nature.torsion_radius_m == 0.0:
        return passage
    return replace(passage, spin=twist(nature, touch, held, passage.spin, bodies))
