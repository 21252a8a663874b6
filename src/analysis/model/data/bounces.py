"""Bounces of one sphere on a plate: each is an impact of its own, with a flight on either side.

A flight between two bounces belongs to both. Its frames are dealt out in turn, every other one to
each: both see the whole arc, and no frame counts twice.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from analysis.exchange.pose_table import PoseRow, Spheres

BOUNCES_A_SHOT = 100
"""The k-th bounce of shot s is impact number 100 s + k."""
MOST_BOUNCES = BOUNCES_A_SHOT - 1
LEAST_FRAMES = 2
"""On either side of a bounce."""
CLEAR_M, CLEAR_SIGMAS = 2e-4, 6.0
"""By how much a sphere falls and rises beside a bounce, at least."""


def by_bounce(shots: Mapping[int, Mapping[str, Sequence[PoseRow]]]) -> dict[int, Spheres]:
    """Return the rows of each bounce, by its number; those of a shot without one are empty.

    Parameters
    ----------
    shots
        Rows of sphere a of each shot; those of b, the plate, are left out. It lies toward +X.
    """
    found: dict[int, Spheres] = {}
    for shot, spheres in shots.items():
        bounces = bounces_of(spheres["a"]) or [[]]
        for k, rows in enumerate(bounces[:MOST_BOUNCES], start=1):
            found[BOUNCES_A_SHOT * shot + k] = {"a": rows, "b": []}
    return found


def bounces_of(rows: Sequence[PoseRow]) -> list[list[PoseRow]]:
    """Return the rows of every bounce of one shot, in the order of time.

    Time counts from the frame in which the sphere is lowest.
    """
    used = [row for row in rows if np.isfinite(row.position[0])]
    touches, end = turning_points(used)
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


def turning_points(rows: Sequence[PoseRow]) -> tuple[list[int], int]:
    """Return in which rows a sphere that has fallen is lowest before it clearly rises.

    The frame may lie on either side of the contact. Beside them stands where the last flight ends:
    where the sphere is lowest, should it not clearly rise any more.
    """
    depth = np.array([row.position[0] for row in rows])
    stated = np.array([row.position_sigma[0] for row in rows])
    stated = stated[np.isfinite(stated)]
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
    return found, lowest if falls else len(rows)
