"""One shot: from two pulses to the poses of both spheres at any time, and what the contact did."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from simulators.world.contact import Contact, Touch, collide
from simulators.world.description import Environment, Sphere, TiltedTubes, WorldDescription
from simulators.world.flight import Flight, acceleration, fly
from simulators.world.launch import Departure, Launch, Loaded, depart
from simulators.world.release import Held, Release, roll
from simulators.world.state import Motion, Pose

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

    Times count from the start of the launch. `later` are the contacts after the first, of a
    sphere that bounces on a plate.
    """

    path_a: Path
    path_b: Path
    contact: Contact | None
    later: tuple[Contact, ...] = ()

    def poses(self, time_s: float) -> tuple[Pose | None, Pose | None]:
        """Return the poses of a and b; None for a sphere that cannot be seen."""
        return self.path_a.at(time_s), self.path_b.at(time_s)


Law = Callable[[Touch], Contact]
"""What two touching spheres do to each other."""


def simulate(
    description: WorldDescription,
    launch: Launch | Release,
    rng: np.random.Generator,
    law: Law | None = None,
) -> Encounter:
    """Launch both spheres, and follow them until they are out of every view.

    Spheres meet once at most: after parting they share gravity, and drag cannot turn them back.
    Without a `law` of its own the contact is that of the description.
    """
    law = partial(collide, law=description.contact) if law is None else law
    a, b = _departures(description, launch, rng)
    if a is not None and b is not None:
        return _meet(description, (a, b), law)
    return Encounter(
        _alone(description.environment, a, description.sphere_a),
        _alone(description.environment, b, description.sphere_b),
        None,
    )


def _departures(
    description: WorldDescription, launch: Launch | Release, rng: np.random.Generator
) -> tuple[Departure | None, Departure | None]:
    """Return how a and b leave their tubes, None for one that stays; times as of `Encounter`."""
    if isinstance(launch, Release):
        return _rolling(description, launch, rng)
    tube = description.tube
    low, high = tube.height_m + launch.offset_m / 2.0, tube.height_m - launch.offset_m / 2.0
    delay_s = launch.fire_b_s - launch.fire_a_s
    tube_a = Loaded(tube, description.sphere_a, high, +1.0)
    tube_b = Loaded(tube, description.sphere_b, low, -1.0)
    return (
        depart(tube_a, launch.pressure_a_kpa, 0.0, rng),
        depart(tube_b, launch.pressure_b_kpa, delay_s, rng),
    )


def _rolling(
    description: WorldDescription, release: Release, rng: np.random.Generator
) -> tuple[Departure | None, Departure | None]:
    tubes = description.holder
    if not isinstance(tubes, TiltedTubes):
        raise TypeError(f"solenoids let go, and the world has {type(tubes).__name__}")
    angle_a_deg, angle_b_deg = release.angles_deg or (tubes.angle_a_deg, tubes.angle_b_deg)
    held = (
        (Held(tubes, description.sphere_a, angle_a_deg, +1.0), release.fire_a_s),
        (Held(tubes, description.sphere_b, angle_b_deg, -1.0), release.fire_b_s),
    )
    a, b = (
        None
        if switched is None or tube.angle_deg == 0.0
        else roll(tube, switched - release.starts_s, description.environment, rng)
        for tube, switched in held
    )
    return a, b


def _alone(environment: Environment, leaving: Departure | None, sphere: Sphere) -> Path:
    if leaving is None:
        return Path()
    end_s = leaving.exit_s + FLIGHT_LASTS_S
    _, stretches = _until(environment, leaving, sphere, end_s)
    return Path(stretches, end_s)


def _until(
    environment: Environment, leaving: Departure, sphere: Sphere, end_s: float
) -> tuple[Motion, tuple[Stretch, ...]]:
    """Follow one sphere through its tube and on alone to `end_s`, not before it has left."""
    in_tube = Stretch(leaving.starts_s, leaving.at)
    if leaving.exit_s == end_s:
        return leaving.exit, (in_tube,)
    flight = fly([leaving.exit], [sphere], leaving.exit_s, end_s, environment)
    return flight.at(end_s)[0], (in_tube, Stretch(leaving.exit_s, partial(flight.pose, 0)))


def _meet(
    description: WorldDescription, leaving: tuple[Departure, Departure], law: Law
) -> Encounter:
    environment = description.environment
    spheres = (description.sphere_a, description.sphere_b)
    start_s = max(leaving[0].exit_s, leaving[1].exit_s)
    end_s = start_s + FLIGHT_LASTS_S
    motion_a, path_a = _until(environment, leaving[0], spheres[0], start_s)
    motion_b, path_b = _until(environment, leaving[1], spheres[1], start_s)
    flight = fly((motion_a, motion_b), spheres, start_s, end_s, environment)
    phases: list[Flight | Contact] = [flight]
    contact = None
    if flight.touch_s is not None:
        contact = law(_touch(flight, flight.touch_s, spheres, environment))
        after = fly(contact.motions[-1], spheres, contact.end_s, end_s, environment)
        phases += [contact, after]
    return Encounter(
        Path((*path_a, *(Stretch(it.start_s, partial(it.pose, 0)) for it in phases)), end_s),
        Path((*path_b, *(Stretch(it.start_s, partial(it.pose, 1)) for it in phases)), end_s),
        contact,
    )


def _touch(
    flight: Flight, time_s: float, spheres: tuple[Sphere, Sphere], environment: Environment
) -> Touch:
    a, b = flight.at(time_s)
    pull_a = acceleration(a.velocity, spheres[0], environment)
    pull_b = acceleration(b.velocity, spheres[1], environment)
    return Touch(time_s, spheres, (a, b), (pull_a, pull_b))
