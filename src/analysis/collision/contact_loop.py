"""Contacts integrated in time, one after the other, compiled.

The state of a contact: centre of b from that of a, its velocity, both spins, and the tangential
spring, three numbers each. The centre of mass moves on as it did.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part

Floats = NDArray[np.float64]

PLACE, VELOCITY, SPIN_A, SPIN_B, SPRING, SIZE = 0, 3, 6, 9, 12, 15
"""Where they begin."""
RADIUS_A, RADIUS_B, GIVE, GIVE_A, GIVE_B, LEVER, TURNS = range(7)
"""Numbers of a pair: radii, m; what a unit impulse changes, 1/kg and 1/(kg m^2); the share of the
overlap that each lever loses; whether the normal turns (1) or is that of a plate (0)."""
STIFFNESS, ELASTIC, LOSS, RATIO, TANGENT_LOSS, BY_INCREMENT, SLIDES = range(7)
"""Numbers of a law: k, p, q; kappa; 2 zeta sqrt(m_t); whether the spring keeps its force (1);
whether the dashpot acts while the contact slides (1)."""
FINER = 8.0
"""Times as small are the steps in which the normal force ends."""
MOST_STEPS = 10_000
"""After which spheres count as not parting: 10 undamped durations of the finest integration."""


@compiled
def collide(
    touch: tuple[Floats, Floats, Floats],
    pair: Floats,
    law: Floats,
    units: tuple[Floats, Floats, Floats],
    steps: int,
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
        As listed above, shape (7,) each.
    units
        Of each contact: c of the normal dashpot, mu, and the undamped duration, s, shape (N,).
    steps
        In an undamped duration.

    Returns
    -------
    States at separation, shape (N, 15); durations, s, shape (N,), not a number where the spheres
    do not part; by what both spheres have turned, rad, shape (N, 2, 3).
    """
    normal, velocity, spins = touch
    dashpot, friction, lasting = units
    count = normal.shape[0]
    ends, durations, turns = np.zeros((count, SIZE)), np.zeros(count), np.zeros((count, 2, 3))
    work, first = np.zeros((3, SIZE)), np.zeros(3)
    for n in range(count):
        state, closing = ends[n], 0.0
        for k in range(3):
            first[k] = normal[n, k]
            state[PLACE + k] = (pair[RADIUS_A] + pair[RADIUS_B]) * normal[n, k]
            state[VELOCITY + k] = velocity[n, k]
            state[SPIN_A + k], state[SPIN_B + k] = spins[n, 0, k], spins[n, 1, k]
            closing -= velocity[n, k] * normal[n, k]
        if closing > 0.0:
            own = dashpot[n], friction[n], lasting[n] / steps
            durations[n] = follow(state, work, turns[n], (first, pair, law), own)
    return ends, durations, turns


@part
def follow(
    state: Floats,
    work: Floats,
    turns: Floats,
    contact: tuple[Floats, Floats, Floats],
    units: tuple[float, float, float],
) -> float:
    """Follow one contact in place; return its duration, s, not a number where it does not end.

    Parameters
    ----------
    work
        Where rates and states on the way are kept, shape (3, 15).
    turns
        Added to, shape (2, 3).
    contact
        Normal at first touch, pair and law.
    units
        c, mu and a step, s.
    """
    first, pair = contact[0], contact[1]
    step, duration, deepest = units[2], 0.0, 0.0
    old, middle, rate = work[0], work[1], work[2]
    for _ in range(MOST_STEPS):
        push = force(state, rate, contact, units[0], units[1])
        overlap = overlap_of(state, first, pair)
        # Only after the deepest: at first touch the overlap is 0 give or take rounding.
        parting = 0.0 < overlap < deepest
        deepest = max(deepest, overlap)
        if parting and push <= 0.0:
            # Nothing pulls: the way out is free.
            wait = time_to_part(state, first, pair, overlap)
            for k in range(3):
                state[PLACE + k] += wait * state[VELOCITY + k]
                turns[0, k] += wait * state[SPIN_A + k]
                turns[1, k] += wait * state[SPIN_B + k]
            return duration + wait
        for k in range(SIZE):
            old[k] = state[k]
            middle[k] = state[k] + 0.5 * step * rate[k]
        uncut = middle[SPRING], middle[SPRING + 1], middle[SPRING + 2]
        pushed = force(middle, rate, contact, units[0], units[1])
        if parting and 2.0 * pushed <= push and step == units[2]:
            # The force ends within this step, with a kink that small steps resolve.
            step /= FINER
            continue
        for k in range(SIZE):
            state[k] += step * rate[k]
        for k in range(3):
            state[SPRING + k] += middle[SPRING + k] - uncut[k]
            turns[0, k] += step * middle[SPIN_A + k]
            turns[1, k] += step * middle[SPIN_B + k]
        duration += step
        if overlap_of(state, first, pair) <= 0.0:
            # The elastic force that is left at the end is less than a step's worth.
            return duration
    return np.nan


@part
def time_to_part(state: Floats, first: Floats, pair: Floats, overlap: float) -> float:
    """Return how long spheres that nothing holds need to part, s."""
    square, along, opening = 0.0, 0.0, 0.0
    for k in range(3):
        square += state[VELOCITY + k] ** 2
        along += state[PLACE + k] * state[VELOCITY + k]
        opening += state[VELOCITY + k] * first[k]
    if pair[TURNS] <= 0.0:
        return overlap / float(max(opening, 1e-300))
    reach = pair[RADIUS_A] + pair[RADIUS_B]
    missing = reach * reach - (reach - overlap) ** 2
    # (|r + u t|)^2 = reach^2, in a form without cancellation.
    root = float(math.sqrt(along * along + square * missing))
    return float(missing / max(along + root, 1e-300))


@part
def overlap_of(state: Floats, first: Floats, pair: Floats) -> float:
    """Return the overlap, m; negative is a gap."""
    along = 0.0
    if pair[TURNS] > 0.0:
        for k in range(3):
            along += state[PLACE + k] ** 2
        along = float(math.sqrt(along))
    else:
        for k in range(3):
            along += state[PLACE + k] * first[k]
    overlap: float = pair[RADIUS_A] + pair[RADIUS_B] - along
    return overlap


@part
def force(
    state: Floats,
    rate: Floats,
    contact: tuple[Floats, Floats, Floats],
    dashpot: float,
    friction: float,
) -> float:
    """Fill the rates of a state, and cut its spring back to what friction holds.

    Returns
    -------
    The normal force, N.
    """
    first, pair, law = contact
    for k in range(SIZE):
        rate[k] = 0.0
    overlap = overlap_of(state, first, pair)
    distance = pair[RADIUS_A] + pair[RADIUS_B] - overlap
    turns = pair[TURNS] > 0.0
    nx = state[0] / distance if turns else first[0]
    ny = state[1] / distance if turns else first[1]
    nz = state[2] / distance if turns else first[2]
    opening = state[3] * nx + state[4] * ny + state[5] * nz
    arm_a = pair[RADIUS_A] - pair[LEVER] * overlap
    arm_b = (pair[RADIUS_B] - pair[LEVER] * overlap) if turns else 0.0
    wx = arm_a * state[6] + arm_b * state[9]
    wy = arm_a * state[7] + arm_b * state[10]
    wz = arm_a * state[8] + arm_b * state[11]
    sx = state[3] - opening * nx - (wy * nz - wz * ny)
    sy = state[4] - opening * ny - (wz * nx - wx * nz)
    sz = state[5] - opening * nz - (wx * ny - wy * nx)
    for k in range(3):
        rate[PLACE + k] = state[VELOCITY + k]
    if overlap <= 0.0:
        # At first touch, give or take rounding: nothing presses yet, but the surfaces slip.
        if law[BY_INCREMENT] == 0.0:
            rate[12], rate[13], rate[14] = sx, sy, sz
        return 0.0
    push, stiff = pressed(overlap, opening, law, dashpot)
    limit = friction * push
    tangent = law[RATIO] * stiff
    damped = law[TANGENT_LOSS] * math.sqrt(tangent)
    # The spring as a force, across the normal and no longer than friction holds.
    scale = 1.0 if law[BY_INCREMENT] > 0.0 else tangent
    gx, gy, gz = scale * state[12], scale * state[13], scale * state[14]
    along = gx * nx + gy * ny + gz * nz
    gx, gy, gz = gx - along * nx, gy - along * ny, gz - along * nz
    size = math.sqrt(gx * gx + gy * gy + gz * gz)
    if size >= limit:
        cut = limit / size if size > 0.0 else 0.0
        gx, gy, gz = cut * gx, cut * gy, cut * gz
        if law[SLIDES] == 0.0:
            damped = 0.0
    state[12], state[13], state[14] = gx / scale, gy / scale, gz / scale
    fx, fy, fz = -gx - damped * sx, -gy - damped * sy, -gz - damped * sz
    size = math.sqrt(fx * fx + fy * fy + fz * fz)
    if size > limit:
        fx, fy, fz = fx * limit / size, fy * limit / size, fz * limit / size
    rate[3] = (push * nx + fx) * pair[GIVE]
    rate[4] = (push * ny + fy) * pair[GIVE]
    rate[5] = (push * nz + fz) * pair[GIVE]
    tx, ty, tz = fy * nz - fz * ny, fz * nx - fx * nz, fx * ny - fy * nx
    give_a, give_b = arm_a * pair[GIVE_A], arm_b * pair[GIVE_B]
    rate[6], rate[7], rate[8] = give_a * tx, give_a * ty, give_a * tz
    rate[9], rate[10], rate[11] = give_b * tx, give_b * ty, give_b * tz
    gain = tangent if law[BY_INCREMENT] > 0.0 else 1.0
    rate[12], rate[13], rate[14] = gain * sx, gain * sy, gain * sz
    return push


@part
def pressed(overlap: float, opening: float, law: Floats, dashpot: float) -> tuple[float, float]:
    """Return the normal force, N, never pulling, and the stiffness of its spring, N/m."""
    root = math.sqrt(overlap)
    stiff = law[STIFFNESS] * law[ELASTIC] * (root if law[ELASTIC] > 1.0 else 1.0)
    elastic = stiff * overlap / law[ELASTIC]
    loss = 1.0
    if law[LOSS] == 0.25:
        loss = math.sqrt(root)
    elif law[LOSS] == 0.5:
        loss = root
    return max(0.0, elastic - dashpot * loss * opening), stiff
