"""Contacts integrated in time, side by side in blocks, compiled."""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.collision.contact_block import (
    DEEPEST,
    DURATION,
    FIRST,
    FULL_STEP,
    HERE,
    LANES,
    MOVED,
    OVERLAP,
    PARTING,
    PLACE,
    PULL,
    PUSH,
    PUSH_BEFORE,
    RADIUS_A,
    RADIUS_B,
    RATE,
    ROWS,
    SIZE,
    SPIN_A,
    SPIN_B,
    SPRING,
    STATE,
    STEP,
    STIFFNESS,
    TURN,
    TURNS,
    UNCUT,
    VELOCITY,
    meet,
    press,
    put,
    three,
    twist,
)
from analysis.compiled import compiled, part

UNITS = 6
"""Of each contact: k, c, mu, kappa, 2 zeta sqrt(m_t) and the undamped duration, s."""
FINER = 8.0
"""Times as small are the steps in which the normal force ends."""
MOST_STEPS = 10_000
"""After which spheres count as not parting: 10 undamped durations of the finest integration."""


@compiled
def collide(
    touch: tuple[Floats, Floats, Floats], pair: Floats, law: Floats, units: Floats, steps: int
) -> tuple[Floats, Floats, Floats]:
    """Follow contacts from first touch until the overlap is gone.

    Midpoint rule; the spring is cut back to Coulomb's limit at every evaluation, and the cut at the
    middle of a step is kept at its end.

    Parameters
    ----------
    touch
        Normals from a to b, velocities of b relative to a, m/s, and both spins, rad/s, shapes
        (N, 3), (N, 3) and (N, 2, 3).
    pair, law
        As `contact_block` lists them, shapes (8,) and (4,).
    units
        Of each contact: k, c of the normal dashpot, mu, kappa, 2 zeta sqrt(m_t), and the undamped
        duration, s, shape (N, 6).
    steps
        In an undamped duration.

    Returns
    -------
    States at separation, shape (N, 15); durations, s, shape (N,), not a number where the spheres
    do not part; by what both spheres have turned, rad, shape (N, 2, 3).
    """
    count, reach = touch[0].shape[0], pair[RADIUS_A] + pair[RADIUS_B]
    ends, durations, turns = np.zeros((count, SIZE)), np.zeros(count), np.zeros((count, 2, 3))
    block = np.zeros(ROWS * LANES)
    for begin in range(0, count, LANES):
        fill(block, begin, touch, units, (reach, steps))
        for _ in range(MOST_STEPS):
            rates(block, pair, law)
            free(block, pair)
            half_way(block)
            rates(block, pair, law)
            if not go_on(block, pair):
                break
        for k in range(min(LANES, count - begin)):
            n = begin + k
            ended = block[STEP * LANES + k] == 0.0
            durations[n] = block[DURATION * LANES + k] if ended else np.nan
            for row in range(SIZE):
                ends[n, row] = block[(STATE + row) * LANES + k]
            for row in range(3):
                turns[n, 0, row] = block[(TURN + row) * LANES + k]
                turns[n, 1, row] = block[(TURN + 3 + row) * LANES + k]
    return ends, durations, turns


@part
def rates(block: Floats, pair: Floats, law: Floats) -> None:
    """Fill in the rates of the states HERE."""
    meet(block, pair)
    press(block, pair, law)
    twist(block, pair)


@part
def fill(
    block: Floats,
    begin: int,
    touch: tuple[Floats, Floats, Floats],
    units: Floats,
    reach_and_steps: tuple[float, int],
) -> None:
    """Set a block to first touch of the contacts from `begin` on, the last repeated to its end."""
    normal, velocity, spins = touch
    reach, steps = reach_and_steps
    for k in range(ROWS * LANES):
        block[k] = 0.0
    for k in range(LANES):
        n, closing = min(begin + k, normal.shape[0] - 1), 0.0
        for row in range(3):
            block[(FIRST + row) * LANES + k] = normal[n, row]
            block[(STATE + PLACE + row) * LANES + k] = reach * normal[n, row]
            block[(STATE + VELOCITY + row) * LANES + k] = velocity[n, row]
            block[(STATE + SPIN_A + row) * LANES + k] = spins[n, 0, row]
            block[(STATE + SPIN_B + row) * LANES + k] = spins[n, 1, row]
            closing -= velocity[n, row] * normal[n, row]
        for row in range(SIZE):
            block[(HERE + row) * LANES + k] = block[(STATE + row) * LANES + k]
        for row in range(UNITS - 1):
            block[(STIFFNESS + row) * LANES + k] = units[n, row]
        step = units[n, UNITS - 1] / steps if closing > 0.0 else 0.0
        block[STEP * LANES + k] = block[FULL_STEP * LANES + k] = step


@part
def free(block: Floats, pair: Floats) -> None:
    """End contacts that nothing presses any more: the rest of the way out is free."""
    turns, reach = pair[TURNS] > 0.0, pair[RADIUS_A] + pair[RADIUS_B]
    for k in range(LANES):
        overlap, push = block[OVERLAP * LANES + k], block[PUSH * LANES + k]
        deepest, step = block[DEEPEST * LANES + k], block[STEP * LANES + k]
        # Only after the deepest: at first touch the overlap is 0 give or take rounding.
        parting = 0.0 < overlap < deepest
        block[DEEPEST * LANES + k] = max(deepest, overlap)
        block[PUSH_BEFORE * LANES + k] = push
        block[PARTING * LANES + k] = 1.0 if parting else 0.0
        px, py, pz = three(block, STATE + PLACE, k)
        ux, uy, uz = three(block, STATE + VELOCITY, k)
        nx, ny, nz = three(block, FIRST, k)
        # (|r + u t|)^2 = reach^2, in a form without cancellation; beside a plate u.n t = overlap.
        along = px * ux + py * uy + pz * uz
        missing = overlap * (2.0 * reach - overlap)
        root = math.sqrt(max(along * along + (ux * ux + uy * uy + uz * uz) * missing, 0.0))
        opening = ux * nx + uy * ny + uz * nz
        wait = missing / max(along + root, 1e-300) if turns else overlap / max(opening, 1e-300)
        freed = parting and push <= 0.0 and step > 0.0
        wait = wait if freed else 0.0
        put(block, STATE + PLACE, k, (px + wait * ux, py + wait * uy, pz + wait * uz))
        block[(STATE + VELOCITY) * LANES + k] -= pair[PULL] * wait
        block[DURATION * LANES + k] += wait
        block[STEP * LANES + k] = 0.0 if freed else step
        for row in range(6):
            block[(TURN + row) * LANES + k] += wait * block[(STATE + SPIN_A + row) * LANES + k]


@part
def half_way(block: Floats) -> None:
    """Go from a step's begin to its middle, with the springs that its begin has cut."""
    for row in range(SPRING, SIZE):
        for k in range(LANES):
            block[(STATE + row) * LANES + k] = block[(HERE + row) * LANES + k]
    for row in range(SIZE):
        for k in range(LANES):
            way = 0.5 * block[STEP * LANES + k] * block[(RATE + row) * LANES + k]
            block[(HERE + row) * LANES + k] = block[(STATE + row) * LANES + k] + way
    for k in range(LANES):
        put(block, UNCUT, k, three(block, HERE + SPRING, k))


@part
def go_on(block: Floats, pair: Floats) -> bool:
    """Take a midpoint step; return whether any contact goes on after it."""
    turns, reach = pair[TURNS] > 0.0, pair[RADIUS_A] + pair[RADIUS_B]
    for k in range(LANES):
        step, full = block[STEP * LANES + k], block[FULL_STEP * LANES + k]
        before, push = block[PUSH_BEFORE * LANES + k], block[PUSH * LANES + k]
        # The force ends within this step, with a kink that small steps resolve.
        ends = block[PARTING * LANES + k] > 0.0 and 2.0 * push <= before
        finer = ends and step == full
        block[MOVED * LANES + k] = 0.0 if finer else step
        block[STEP * LANES + k] = step / FINER if finer else step
    for row in range(6):
        for k in range(LANES):
            turn = block[MOVED * LANES + k] * block[(HERE + SPIN_A + row) * LANES + k]
            block[(TURN + row) * LANES + k] += turn
    for row in range(3):
        for k in range(LANES):
            moved = block[MOVED * LANES + k] > 0.0
            cut = block[(HERE + SPRING + row) * LANES + k] - block[(UNCUT + row) * LANES + k]
            block[(STATE + SPRING + row) * LANES + k] += cut if moved else 0.0
    for row in range(SIZE):
        for k in range(LANES):
            way = block[MOVED * LANES + k] * block[(RATE + row) * LANES + k]
            block[(STATE + row) * LANES + k] += way
    for k in range(LANES):
        px, py, pz = three(block, STATE + PLACE, k)
        nx, ny, nz = three(block, FIRST, k)
        moved, step = block[MOVED * LANES + k], block[STEP * LANES + k]
        centres = math.sqrt(px * px + py * py + pz * pz)
        distance = centres if turns else px * nx + py * ny + pz * nz
        # The elastic force that is left at the end is less than a step's worth.
        ended = moved > 0.0 and distance >= reach
        block[DURATION * LANES + k] += moved
        block[STEP * LANES + k] = 0.0 if ended else step
    for row in range(SIZE):
        for k in range(LANES):
            block[(HERE + row) * LANES + k] = block[(STATE + row) * LANES + k]
    going = 0.0
    for k in range(LANES):
        going += block[STEP * LANES + k]
    return going > 0.0
