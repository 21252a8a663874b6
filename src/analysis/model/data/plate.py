"""How a plate lies that a sphere bounces on; each bounce is an impact with a flight on either side.

A flight between two bounces belongs to both. Its frames are dealt out in turn, every other one to
each: both see the whole arc, and no frame counts twice.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.exchange.pose_table import PoseRow, Spheres
from analysis.setup import SphereSetup

LEVEL_WITHIN_RAD = 0.01
"""What a spirit level leaves of a plate, and of the camera against it."""


@dataclass(frozen=True, slots=True)
class Plate:
    """A plane.

    Attributes
    ----------
    normal
        Unit vector from the sphere into it, rig axes; of a level plate along +X.
    sigma_rad
        Standard error of its direction about each of two axes.
    """

    normal: tuple[float, float, float] = (1.0, 0.0, 0.0)
    sigma_rad: float = LEVEL_WITHIN_RAD


LEVEL = Plate()


def stated_plate(body: SphereSetup) -> Plate:
    """Return the plate that campaign.toml states, or a level one where it states no normal."""
    if body.normal is None:
        return LEVEL
    x, y, z = np.array(body.normal) / np.linalg.norm(body.normal)
    return Plate((float(x), float(y), float(z)))


BOUNCES_A_SHOT = 100
"""The k-th bounce of shot s is impact number 100 s + k."""
MOST_BOUNCES = BOUNCES_A_SHOT - 1
LEAST_FRAMES = 2
"""On either side of a bounce."""
CLEAR_M, CLEAR_SIGMAS = 2e-4, 6.0
"""By how much a sphere comes near and leaves beside a bounce, at least."""
BESIDE, LEAST_KINK = 4, 0.3
"""Frames on either side that tell a bounce from a sphere that turns back on its own, and by which
part of the larger speed it breaks."""
STANDARD_GRAVITY = 9.80665


def by_bounce(
    shots: Mapping[int, Mapping[str, Sequence[PoseRow]]], plate: Plate, gravity: float
) -> dict[int, Spheres]:
    """Return the rows of each bounce, by its number; those of a shot without one are empty.

    Parameters
    ----------
    shots
        Rows of sphere a of each shot; those of b, the plate, are left out.
    gravity
        m/s^2 along +X.
    """
    found: dict[int, Spheres] = {}
    for shot, spheres in shots.items():
        bounces = bounces_of(spheres["a"], plate, gravity) or [[]]
        for k, rows in enumerate(bounces[:MOST_BOUNCES], start=1):
            found[BOUNCES_A_SHOT * shot + k] = {"a": rows, "b": []}
    return found


def bounces_of(
    rows: Sequence[PoseRow], plate: Plate = LEVEL, gravity: float = STANDARD_GRAVITY
) -> list[list[PoseRow]]:
    """Return the rows of every bounce of one shot, in the order of time.

    Time counts from the frame in which the sphere is deepest, that is farthest along the normal.
    """
    used, depth, sigma = deep(rows, plate)
    touches, end = turning_points(depth, sigma)
    if plate.normal[0] < 0.0:
        # Gravity pulls the sphere off such a plate: it turns back without having touched, too.
        times = np.array([row.t_s for row in used])
        straight = depth - 0.5 * gravity * plate.normal[0] * times**2
        touches = [k for k in touches if kinks(times, straight, k)]
    ends = [-1, *touches, end]
    found = []
    for k in range(1, len(ends) - 1):
        before, after = used[ends[k - 1] + 1 : ends[k]], used[ends[k] + 1 : ends[k + 1]]
        before = before[:: 1 if k == 1 else 2]
        after = after if k == len(ends) - 2 else after[1::2]
        if min(len(before), len(after)) < LEAST_FRAMES:
            continue
        lowest = used[ends[k]]
        own = (*before, lowest, *after)
        found.append([replace(row, t_s=row.t_s - lowest.t_s) for row in own])
    return found


def deep(rows: Sequence[PoseRow], plate: Plate) -> tuple[list[PoseRow], Floats, Floats]:
    """Return the rows whose depth along the plate's normal is known, with it and its sigma, m."""
    normal = np.array(plate.normal)
    along = np.flatnonzero(normal)
    places = np.array([row.position for row in rows]).reshape(-1, 3)[:, along]
    sigmas = np.array([row.position_sigma for row in rows]).reshape(-1, 3)[:, along]
    known = np.isfinite(places).all(axis=1)
    sigma = np.sqrt((sigmas**2 * normal[along] ** 2).sum(axis=1))
    used = [row for row, seen in zip(rows, known, strict=True) if seen]
    return used, places[known] @ normal[along], sigma[known]


def turning_points(depth: Floats, sigma: Floats) -> tuple[list[int], int]:
    """Return in which frames a sphere that came near is deepest before it clearly leaves.

    The frame may lie on either side of the contact. Beside them stands where the last flight ends:
    where the sphere is deepest, should it not clearly leave any more.
    """
    stated = sigma[np.isfinite(sigma)]
    clear = max(CLEAR_M, CLEAR_SIGMAS * float(np.median(stated)) if stated.size else 0.0)
    found, highest, lowest, falls = list[int](), 0, 0, False
    for k, x in enumerate(depth):
        if not falls:
            highest = k if x < depth[highest] else highest
            falls = bool(x > depth[highest] + clear)
            lowest = k
        elif x > depth[lowest]:
            lowest = k
        elif x < depth[lowest] - clear:
            found.append(lowest)
            highest, falls = k, False
    return found, lowest if falls else len(depth)


def kinks(times: Floats, straight: Floats, at: int) -> bool:
    """Return whether a track that is straight in free flight breaks at a frame."""
    before, after = slice(max(0, at - BESIDE), at), slice(at + 1, at + 1 + BESIDE)
    if min(len(times[before]), len(times[after])) < LEAST_FRAMES:
        return False
    came, left = (np.polyfit(times[own], straight[own], 1)[0] for own in (before, after))
    return bool(came - left > LEAST_KINK * max(abs(came), abs(left)))
