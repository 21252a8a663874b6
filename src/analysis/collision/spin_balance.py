"""Whether a sphere's spin changes as the impulse on both asks for: a test of followed turns.

One impulse J at the contact changes velocity and spin of a sphere together, I (w' - w) = -R n x J,
whatever the law of contact. Orientations seen by few markers may be followed in a wrong turn that
is as smooth as a true one; velocities, which come from the outlines, contradict it, and so does the
other sphere, which the same impulse turns.
"""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.collision.coefficients import Impact
from analysis.collision.operator import Body

ALONG_Z = np.array([0.0, 0.0, 1.0])
MOST_OFF, AGREES = 3.0, 1.0
"""Of what errors allow: spins off by more contradict the impulse that velocities show, where the
other sphere's agree with it. A law of contact that the balance lacks, as a moment of its own, would
bring both off alike."""
MOST_APART, LESS_SURE, MORE_OFF, OFF = 0.8, 2.0, 3.0, 0.5
"""Of what errors and moments allow: spins of a and b whose changes differ by more contradict each
other (right ones do by 0.3 at most). Wrong are those of so many times the other's error, or those
that are so many times as far off the impulse that velocities show, and by as much (right ones are
by 0.25 at most)."""
NORMAL_TURNS = 0.01
"""Share of the impulse that the normal turns by during a contact of unknown length, at least."""


def contradicted(impact: Impact, bodies: tuple[Body, Body], *, depth_seen: bool) -> int | None:
    """Return the sphere, 0 for a and 1 for b, whose spins are wrong; None where none are.

    They contradict the impulse that velocities show, with which the other sphere's agree; or both
    contradict each other, and its are by far the less sure ones, or further off velocities.
    """
    off = spins_off(impact, bodies, depth_seen=depth_seen)
    worst = int(np.nan_to_num(off).argmax())
    if off[worst] > MOST_OFF and off[1 - worst] < AGREES:
        return worst
    # Not a number where a spin is not measured: then there is no comparison.
    if not spins_apart(impact, bodies) > MOST_APART:
        return None
    errors = np.linalg.norm(impact.state_sigma[:, 2:], axis=(0, 2))
    unsure = int(errors.argmax())
    if errors[unsure] > LESS_SURE * errors[1 - unsure]:
        return unsure
    return worst if off[worst] > max(OFF, MORE_OFF * off[1 - worst]) else None


def spins_apart(impact: Impact, bodies: tuple[Body, Body]) -> float:
    """Return by how much the changes of both spins differ, over what errors and moments allow.

    One impulse turns both spheres across the normal,
    I_a (w_a' - w_a) / R_a = I_b (w_b' - w_b) / R_b. About the normal it turns neither, and a moment
    of the contact's own turns them against each other: that part does not count. Not a number where
    a spin is not measured, and with a plate.
    """
    before, after = impact.before, impact.after
    velocity = (after.velocity_b - before.velocity_b) - (after.velocity_a - before.velocity_a)
    changes = after.spin_a - before.spin_a, after.spin_b - before.spin_b
    if any(body.is_plate for body in bodies):
        return float("nan")
    levers = np.array([body.inertia / body.radius for body in bodies])
    across = 1.0 - impact.normal**2
    errors = levers * np.sqrt((impact.state_sigma[:, 2:] ** 2 @ across).sum(axis=0))
    impulse = float(np.linalg.norm(velocity)) / sum(1.0 / body.mass for body in bodies)
    moments = _normal_turns(impact, bodies) * impulse
    apart = np.cross(impact.normal, levers[0] * changes[0] - levers[1] * changes[1])
    return float(np.linalg.norm(apart) / np.hypot(np.linalg.norm(errors), moments))


def spins_off(impact: Impact, bodies: tuple[Body, Body], *, depth_seen: bool) -> Floats:
    """Return by how much each sphere's change of spin is off, over what errors allow, shape (2,).

    The largest of the components across the normal; without depth that about Z, which velocities in
    the picture give. Not a number where a spin is not measured, and of a plate.

    Parameters
    ----------
    bodies
        Of a and b.
    depth_seen
        Whether Z was measured.
    """
    before, after = impact.before, impact.after
    changes = after.velocity_a - before.velocity_a, after.velocity_b - before.velocity_b
    spins = after.spin_a - before.spin_a, after.spin_b - before.spin_b
    errors = np.linalg.norm(impact.state_sigma, axis=0)
    unsure = _normal_turns(impact, bodies)
    off = np.full(2, np.nan)
    for i, body in enumerate(bodies):
        if body.is_plate or not np.isfinite(spins[i]).all():
            continue
        gain = (1.0 if i == 0 else -1.0) * body.mass * body.radius / body.inertia
        left = spins[i] - gain * np.cross(impact.normal, changes[i])
        left = left - (left @ impact.normal) * impact.normal if depth_seen else left * ALONG_Z
        speed = np.linalg.norm(errors[i]) + unsure * np.linalg.norm(changes[i])
        off[i] = np.max(np.abs(left) / np.hypot(errors[2 + i], abs(gain) * speed))
    return off


def _normal_turns(impact: Impact, bodies: tuple[Body, Body]) -> float:
    """Return by how much the normal may turn while the contact lasts, rad."""
    relative = impact.before.velocity_b - impact.before.velocity_a
    across = float(np.linalg.norm(np.cross(impact.normal, relative)))
    lasts = 0.0 if impact.duration is None else impact.duration.value + impact.duration.sigma
    return max(NORMAL_TURNS, across * lasts / (bodies[0].radius + bodies[1].radius))
