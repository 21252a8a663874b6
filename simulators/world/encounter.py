"""One shot: from two pulses to the poses of both spheres at any time, and what the contact did."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from simulators.world.contact import Contact, collide
from simulators.world.description import Sphere, WorldDescription
from simulators.world.flight import Flight, acceleration, fly
from simulators.world.launch import Departure, Launch, depart
from simulators.world.state import Pose

FLIGHT_LASTS_S = 0.3
"""After this long in the air a sphere has fallen 0.4 m and is out of every view."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """A part of a path: from `start_s` on the pose is `pose(time_s)`."""

    start_s: float
    pose: Callable[[float], Pose]


@dataclass(frozen=True, slots=True)
class Path:
    """Where one sphere is at any time; nowhere to be seen before its start and after its end."""

    stretches: tuple[Stretch, ...] = ()
    end_s: float = -np.inf

    def at(self, time_s: float) -> Pose | None:
        """Return the pose, or None while the sphere is in its tube or gone."""
        index = bisect_right([s.start_s for s in self.stretches], time_s) - 1
        if index < 0 or time_s >= self.end_s:
            return None
        return self.stretches[index].pose(time_s)


@dataclass(frozen=True, slots=True)
class Encounter:
    """The paths of both spheres and their contact, None if they missed.

    Times count from the pulse on pusher a.
    """

    path_a: Path
    path_b: Path
    contact: Contact | None

    def poses(self, time_s: float) -> tuple[Pose | None, Pose | None]:
        """Return the poses of a and b; None for a sphere that cannot be seen."""
        return self.path_a.at(time_s), self.path_b.at(time_s)


def simulate(description: WorldDescription, launch: Launch, rng: np.random.Generator) -> Encounter:
    """Fire both pushers, and follow the spheres until they are out of every view.

    Spheres meet once at most: after parting they share gravity, and drag cannot turn them back.
    """
    tube = description.tube
    low, high = tube.height_m + launch.offset_m / 2.0, tube.height_m - launch.offset_m / 2.0
    delay_s = launch.fire_b_s - launch.fire_a_s
    a = depart(launch.pressure_a_kpa, high, +1.0, 0.0, description.sphere_a, tube, rng)
    b = depart(launch.pressure_b_kpa, low, -1.0, delay_s, description.sphere_b, tube, rng)
    if a is not None and b is not None:
        return _meet(description, a, b)
    return Encounter(
        _alone(description, a, description.sphere_a),
        _alone(description, b, description.sphere_b),
        None,
    )


def _alone(description: WorldDescription, leaving: Departure | None, sphere: Sphere) -> Path:
    if leaving is None:
        return Path()
    end_s = leaving.exit_s + FLIGHT_LASTS_S
    flight = fly([leaving.exit], [sphere], leaving.exit_s, end_s, description.environment)
    return _path(leaving, [Stretch(flight.start_s, partial(flight.pose, 0))], end_s)


def _meet(description: WorldDescription, a: Departure, b: Departure) -> Encounter:
    spheres = (description.sphere_a, description.sphere_b)
    environment = description.environment
    leaving = (a, b)
    start_s = max(a.exit_s, b.exit_s)
    end_s = start_s + FLIGHT_LASTS_S
    initial = []
    stretches: tuple[list[Stretch], list[Stretch]] = ([], [])
    for one, sphere, its in zip(leaving, spheres, stretches, strict=True):
        motion = one.exit
        if one.exit_s < start_s:
            ahead = fly([motion], [sphere], one.exit_s, start_s, environment)
            its.append(Stretch(one.exit_s, partial(ahead.pose, 0)))
            motion = ahead.at(start_s)[0]
        initial.append(motion)
    together = fly(initial, spheres, start_s, end_s, environment)
    _append(stretches, start_s, together)
    contact = None
    if together.touch_s is not None:
        touching = together.at(together.touch_s)
        outer = [
            acceleration(motion.velocity, sphere, environment)
            for motion, sphere in zip(touching, spheres, strict=True)
        ]
        contact = collide(
            touching[0],
            touching[1],
            spheres,
            together.touch_s,
            description.contact,
            (outer[0], outer[1]),
        )
        _append(stretches, together.touch_s, contact)
        parted_s = float(contact.times_s[-1])
        after = fly(contact.motions[-1], spheres, parted_s, end_s, environment)
        _append(stretches, parted_s, after)
    return Encounter(_path(a, stretches[0], end_s), _path(b, stretches[1], end_s), contact)


def _append(
    stretches: tuple[list[Stretch], list[Stretch]], start_s: float, phase: Flight | Contact
) -> None:
    for index, its in enumerate(stretches):
        its.append(Stretch(start_s, partial(phase.pose, index)))


def _path(leaving: Departure, stretches: Sequence[Stretch], end_s: float) -> Path:
    return Path((Stretch(leaving.starts_s, leaving.at), *stretches), end_s)
