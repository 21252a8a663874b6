"""Forces of a block of contacts that are integrated side by side, compiled.

The numbers of a block stand in rows of LANES contacts each, all in one array: the same arithmetic
for each contact of a row is done by vector instructions. Which rows there are is listed below; that
no two of them overlap is plain to the compiler, so that it makes one loop of each.
"""

from __future__ import annotations

import math

from analysis.arrays import Floats
from analysis.compiled import part

LANES = 8
PLACE, VELOCITY, SPIN_A, SPIN_B, SPRING, SIZE = 0, 3, 6, 9, 12, 15
"""The state of a contact: centre of b from that of a, its velocity, both spins, and the tangential
spring, three numbers each. The centre of mass moves on as it did."""
STATE, HERE, RATE = 0, SIZE, 2 * SIZE
"""First rows of: states, states at which forces are evaluated, and their rates."""
TURN, FIRST, UNCUT = 3 * SIZE, 3 * SIZE + 6, 3 * SIZE + 9
"""By what both spheres have turned, normals at first touch, and springs before they were cut."""
NORMAL, SLIP, FORCE = 3 * SIZE + 12, 3 * SIZE + 15, 3 * SIZE + 18
OVERLAP, OPENING, ARM_A, ARM_B, PUSH = range(3 * SIZE + 21, 3 * SIZE + 26)
"""HERE: normal, slip, m/s, and force across it on b, N; overlap, m, and its rate of opening, m/s;
levers, m; normal force, N."""
DURATION, DEEPEST, STEP, FULL_STEP, MOVED, PUSH_BEFORE, PARTING = range(PUSH + 1, PUSH + 8)
"""Duration and deepest overlap so far; the step, s, 0 when a contact has ended, that of the way in,
and the one taken; force at the begin of a step; whether the spheres are on their way out."""
STIFFNESS, DASHPOT, FRICTION, RATIO, TANGENT_LOSS, ROWS = range(PARTING + 1, PARTING + 7)
"""Of each contact: k, c, mu, kappa and 2 zeta sqrt(m_t)."""
RADIUS_A, RADIUS_B, GIVE, GIVE_A, GIVE_B, LEVER, TURNS, PULL = range(8)
"""Numbers of a pair: radii, m; what a unit impulse changes, 1/kg and 1/(kg m^2); the share of the
overlap that each lever loses; whether the normal turns (1) or is that of a plate (0); by how much
more a is pulled along +X than b, m/s^2."""
ELASTIC, LOSS, BY_INCREMENT, SLIDES = range(4)
"""Numbers of a law: p, q; whether the spring keeps its force (1); whether the dashpot acts while
the contact slides (1)."""
TOUCHING = 1e-13
"""Overlap over the sum of the radii that is the rounding of places: spheres touch there, and
nothing presses them yet."""


@part
def three(block: Floats, row: int, k: int) -> tuple[float, float, float]:
    """Return three numbers of contact k, from a row on."""
    here = row * LANES + k
    return block[here], block[here + LANES], block[here + 2 * LANES]


@part
def put(block: Floats, row: int, k: int, numbers: tuple[float, float, float]) -> None:
    """Keep three numbers of contact k, from a row on."""
    here = row * LANES + k
    block[here], block[here + LANES], block[here + 2 * LANES] = numbers


@part
def meet(block: Floats, pair: Floats) -> None:
    """Fill in how the spheres lie HERE, and how their surfaces slip."""
    reach, turns = pair[RADIUS_A] + pair[RADIUS_B], pair[TURNS] > 0.0
    radius_a, radius_b, lever = pair[RADIUS_A], pair[RADIUS_B], pair[LEVER]
    for k in range(LANES):
        px, py, pz = three(block, HERE + PLACE, k)
        ux, uy, uz = three(block, HERE + VELOCITY, k)
        ax, ay, az = three(block, HERE + SPIN_A, k)
        bx, by, bz = three(block, HERE + SPIN_B, k)
        nx, ny, nz = three(block, FIRST, k)
        distance = px * nx + py * ny + pz * nz
        if turns:
            distance = math.sqrt(px * px + py * py + pz * pz)
            unit = 1.0 / distance
            nx, ny, nz = px * unit, py * unit, pz * unit
        overlap = reach - distance
        opening = ux * nx + uy * ny + uz * nz
        arm_a = radius_a - lever * overlap
        arm_b = radius_b - lever * overlap if turns else 0.0
        wx, wy, wz = arm_a * ax + arm_b * bx, arm_a * ay + arm_b * by, arm_a * az + arm_b * bz
        sx = ux - opening * nx - (wy * nz - wz * ny)
        sy = uy - opening * ny - (wz * nx - wx * nz)
        sz = uz - opening * nz - (wx * ny - wy * nx)
        put(block, NORMAL, k, (nx, ny, nz))
        put(block, SLIP, k, (sx, sy, sz))
        put(block, OVERLAP, k, (overlap, opening, arm_a))
        block[ARM_B * LANES + k] = arm_b


@part
def press(block: Floats, pair: Floats, law: Floats) -> None:
    """Fill in normal forces and rates HERE, where `meet` has been.

    Springs are cut back to what friction holds.
    """
    give, touching = pair[GIVE], TOUCHING * (pair[RADIUS_A] + pair[RADIUS_B])
    exponent, hertzian = law[ELASTIC], law[ELASTIC] > 1.0
    half, quarter = law[LOSS] == 0.5, law[LOSS] == 0.25
    pull = pair[PULL]
    keeps, slides = law[BY_INCREMENT] > 0.0, law[SLIDES] > 0.0
    for k in range(LANES):
        nx, ny, nz = three(block, NORMAL, k)
        sx, sy, sz = three(block, SLIP, k)
        overlap, opening, _ = three(block, OVERLAP, k)
        stiffness, dashpot, friction = three(block, STIFFNESS, k)
        # Before anything presses the surfaces slip already.
        pressed = overlap > touching
        depth = overlap if pressed else 0.0
        root = math.sqrt(depth)
        stiff = stiffness * exponent * (root if hertzian else 1.0)
        loss = root if half else (math.sqrt(root) if quarter else 1.0)
        push = stiff * depth / exponent - dashpot * loss * opening
        push = push if pressed and push > 0.0 else 0.0
        limit = friction * push
        tangent = block[RATIO * LANES + k] * stiff
        damped = block[TANGENT_LOSS * LANES + k] * math.sqrt(tangent)
        # The spring as a force, across the normal and no longer than friction holds.
        scale = tangent if pressed and not keeps else 1.0
        gx, gy, gz = three(block, HERE + SPRING, k)
        along = gx * nx + gy * ny + gz * nz
        gx, gy, gz = gx - along * nx, gy - along * ny, gz - along * nz
        size = scale * math.sqrt(gx * gx + gy * gy + gz * gz)
        cut = limit / size if size > limit else 1.0
        gx, gy, gz = cut * gx, cut * gy, cut * gz
        put(block, HERE + SPRING, k, (gx, gy, gz))
        damped = 0.0 if size >= limit and not slides else damped
        fx, fy, fz = -scale * gx - damped * sx, -scale * gy - damped * sy, -scale * gz - damped * sz
        size = math.sqrt(fx * fx + fy * fy + fz * fz)
        held = limit / size if size > limit else 1.0
        fx, fy, fz = held * fx, held * fy, held * fz
        block[PUSH * LANES + k] = push
        put(block, FORCE, k, (fx, fy, fz))
        along = push * give
        ux, uy, uz = along * nx + give * fx, along * ny + give * fy, along * nz + give * fz
        put(block, RATE + VELOCITY, k, (ux - pull, uy, uz))
        gain = tangent if keeps else 1.0
        put(block, RATE + SPRING, k, (gain * sx, gain * sy, gain * sz))


@part
def twist(block: Floats, pair: Floats) -> None:
    """Fill in the rates of spins and places, where `press` has been."""
    give_a, give_b = pair[GIVE_A], pair[GIVE_B]
    for k in range(LANES):
        nx, ny, nz = three(block, NORMAL, k)
        fx, fy, fz = three(block, FORCE, k)
        by_a, by_b = block[ARM_A * LANES + k] * give_a, block[ARM_B * LANES + k] * give_b
        tx, ty, tz = fy * nz - fz * ny, fz * nx - fx * nz, fx * ny - fy * nx
        put(block, RATE + PLACE, k, three(block, HERE + VELOCITY, k))
        put(block, RATE + SPIN_A, k, (by_a * tx, by_a * ty, by_a * tz))
        put(block, RATE + SPIN_B, k, (by_b * tx, by_b * ty, by_b * tz))
