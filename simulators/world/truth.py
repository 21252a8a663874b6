"""What really happened in a shot: for judging a measurement, never for making one."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from simulators.world.contact import Contact
from simulators.world.description import Sphere
from simulators.world.state import Motion

Vector = list[float]


class Truth(TypedDict, total=False):
    """The state at contact; vectors in rig axes, pairs are (a, b), SI units.

    `normal` is the unit vector from a to b at first touch and `normal_after` at separation. The
    four scalars are taken along and across `normal`, with the signs of thesis section 7.1:
    v_n = (V_b - V_a) . normal is negative before contact; v_s is the length of the incident
    surface velocity and v_s_after the component along its direction. `missed` shots hold nothing
    of the contact. `contact_time_s` counts from the pulse on pusher a, or from the first frame in
    a `FilmedTruth`.
    """

    shot: int
    missed: bool
    fire_a_s: float
    fire_b_s: float
    pressure_a_kpa: float
    pressure_b_kpa: float
    offset_m: float
    contact_time_s: float
    contact_duration_s: float
    compression_m: float
    v_n: float
    v_s: float
    v_n_after: float
    v_s_after: float
    normal: Vector
    normal_after: Vector
    centre_at_contact: list[Vector]
    orientation_at_contact: list[Vector]
    velocity_before: list[Vector]
    velocity_after: list[Vector]
    spin_before: list[Vector]
    spin_after: list[Vector]


class FilmedTruth(Truth, total=False):
    """The truth of a shot that was filmed, with what each frame shows.

    For each frame a pair (a, b), None for a sphere in its tube: centres as (row, column) in both
    views, where integers are pixel centres, and the orientation (4,).
    """

    centres_front_px: list[list[tuple[float, float] | None]]
    centres_top_px: list[list[tuple[float, float] | None]]
    rotation_quaternion: list[list[Vector | None]]


def contact_truth(contact: Contact | None, spheres: tuple[Sphere, Sphere]) -> Truth:
    """Return what the contact did; `contact_time_s` is in the clock of the contact."""
    if contact is None:
        return Truth(missed=True)
    before, after = contact.motions[0], contact.motions[-1]
    v_n, surface = _relative(before, contact.normal, spheres)
    v_n_after, surface_after = _relative(after, contact.normal, spheres)
    v_s = float(np.linalg.norm(surface))
    return Truth(
        missed=False,
        contact_time_s=contact.start_s,
        contact_duration_s=_overlapping_s(contact),
        compression_m=contact.compression_m,
        v_n=v_n,
        v_s=v_s,
        v_n_after=v_n_after,
        v_s_after=float(surface_after @ surface) / v_s if v_s > 0.0 else 0.0,
        normal=contact.normal.tolist(),
        normal_after=contact.normal_after.tolist(),
        centre_at_contact=[motion.centre.tolist() for motion in before],
        orientation_at_contact=[motion.orientation.tolist() for motion in before],
        velocity_before=[motion.velocity.tolist() for motion in before],
        velocity_after=[motion.velocity.tolist() for motion in after],
        spin_before=[motion.spin.tolist() for motion in before],
        spin_after=[motion.spin.tolist() for motion in after],
    )


def _overlapping_s(contact: Contact) -> float:
    """Return how long the spheres overlap, s; they may be followed for longer."""
    apart = np.array([b.centre - a.centre for a, b in contact.motions])
    gaps = np.linalg.norm(apart, axis=1) - np.linalg.norm(apart[0])
    opening = slice(int(gaps.argmin()), None)
    return float(np.interp(0.0, gaps[opening], contact.times_s[opening])) - contact.start_s


def _relative(
    pair: tuple[Motion, Motion], normal: NDArray[np.float64], spheres: tuple[Sphere, Sphere]
) -> tuple[float, NDArray[np.float64]]:
    """Return normal speed and surface velocity (3,) of b against a at the point of contact."""
    a, b = pair
    relative = b.velocity - a.velocity
    rolling = np.cross(spheres[0].radius_m * a.spin + spheres[1].radius_m * b.spin, normal)
    along = float(relative @ normal)
    return along, relative - along * normal - rolling


def append_line(path: Path, record: object) -> None:
    """Append one JSON line and return once it is on the disk."""
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(record) + "\n")
        file.flush()
        os.fsync(file.fileno())
