"""Whether a sphere's spin changes as the impulse on both asks for: a test of followed turns.

One impulse J at the contact changes velocity and spin of a sphere together, I (w' - w) = -R n x J,
whatever the law of contact. Orientations seen by few markers may be followed in a wrong turn that
is as smooth as a true one; velocities, which come from the outlines, contradict it, and so does the
other sphere, which the same impulse turns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from analysis.arrays import Floats
from analysis.collision.coefficients import Impact
from analysis.collision.operator import Body
from analysis.setup import HOLLOW_SHELL

ALONG_Z = np.array([0.0, 0.0, 1.0])
MOST_OFF, AGREES = 3.0, 1.0
"""Of what errors allow: spins off by more contradict the impulse that velocities show, where the
other sphere's agree with it, or the sum of both is off as well."""
HEAVY_CORE = 0.2
"""Least moment of inertia of a ball, over m R^2: all its mass within 0.7 of its radius. A ball may
differ from what is stated of it as far as to that, or to a hollow shell: its shots show that."""
MOST_APART, LESS_SURE, MORE_OFF, OFF = 0.8, 2.0, 3.0, 0.5
"""Of what errors and moments allow: spins of a and b whose changes differ by more contradict each
other (right ones do by 0.3 at most). Wrong are those of so many times the other's error, or those
that are so many times as far off the impulse that velocities show, and by as much (right ones are
by 0.25 at most)."""
NORMAL_TURNS = 0.01
"""Share of the impulse that the normal turns by during a contact of unknown length, at least."""


def contradicted(impact: Impact, bodies: tuple[Body, Body], *, depth_seen: bool) -> tuple[int, ...]:
    """Return the spheres, 0 for a and 1 for b, whose spins are wrong.

    They contradict the impulse that velocities show, with which the other sphere's agree; or both
    contradict each other, and its are by far the less sure ones, or further off velocities. Both
    are wrong where the sum of both contradicts the impulse.
    """
    off = spins_off(impact, bodies, depth_seen=depth_seen)
    worst = int(np.nan_to_num(off).argmax())
    if off[worst] > MOST_OFF and off[1 - worst] < AGREES:
        return (worst,)
    # Not a number where a spin is not measured: then there is no comparison.
    if spins_apart(impact, bodies) > MOST_APART:
        errors = np.linalg.norm(impact.state_sigma[:, 2:], axis=(0, 2))
        unsure = int(errors.argmax())
        if errors[unsure] > LESS_SURE * errors[1 - unsure]:
            return (unsure,)
        if off[worst] > max(OFF, MORE_OFF * off[1 - worst]):
            return (worst,)
    return (0, 1) if sum_off(impact, bodies, depth_seen=depth_seen) > MOST_OFF else ()


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
    changes = _changes(impact, bodies, depth_seen=depth_seen)
    return np.asarray((np.abs(changes.seen - changes.asked) / changes.errors).max(axis=1))


def sum_off(impact: Impact, bodies: tuple[Body, Body], *, depth_seen: bool) -> float:
    """Return by how much the spins of both spheres together are off, over what errors allow.

    Whatever acts between the spheres, a moment at their contact included, both together change
    their angular momentum as the impulse does,
    I_a (w_a' - w_a) + I_b (w_b' - w_b) = -(R_a + R_b) n x J. Moments of inertia are any that a ball
    may have, from HEAVY_CORE to HOLLOW_SHELL. Not a number where a spin is not measured, and with a
    plate.
    """
    changes = _changes(impact, bodies, depth_seen=depth_seen)
    if not np.isfinite([changes.seen, changes.asked]).all():
        return float("nan")
    inertia = np.array([body.inertia for body in bodies])
    shell = np.array([body.mass * body.radius**2 for body in bodies])
    errors = inertia @ changes.errors
    fitted = lsq_linear(
        (changes.seen / errors).T,
        inertia @ changes.asked / errors,
        (HEAVY_CORE * shell, HOLLOW_SHELL * shell),
    )
    return float(np.abs(fitted.fun).max())


@dataclass(frozen=True, slots=True, eq=False)
class _Changes:
    """Changes of both spheres' spins across the normal; without depth about Z alone, rad/s.

    `seen` are those of orientations, `asked` those of the impulse that velocities show, `errors`
    what both leave open. Each shape (2, 3), not a number where it is not known.
    """

    seen: Floats
    asked: Floats
    errors: Floats


def _changes(impact: Impact, bodies: tuple[Body, Body], *, depth_seen: bool) -> _Changes:
    before, after, normal = impact.before, impact.after, impact.normal
    pushed = np.stack([after.velocity_a - before.velocity_a, after.velocity_b - before.velocity_b])
    turned = np.stack([after.spin_a - before.spin_a, after.spin_b - before.spin_b])
    levers = [
        np.nan if body.is_plate else body.mass * body.radius / body.inertia for body in bodies
    ]
    gains = np.array(levers)[:, None] * [[1.0], [-1.0]]
    asked = gains * np.cross(normal, pushed)
    errors = np.linalg.norm(impact.state_sigma, axis=0)
    speeds = np.linalg.norm(errors[:2], axis=1) + _normal_turns(impact, bodies) * np.linalg.norm(
        pushed, axis=1
    )
    unsure = np.hypot(errors[2:], np.abs(gains) * speeds[:, None])
    if depth_seen:
        across = np.eye(3) - np.outer(normal, normal)
        return _Changes(turned @ across, asked @ across, unsure)
    return _Changes(turned * ALONG_Z, asked * ALONG_Z, unsure)


def _normal_turns(impact: Impact, bodies: tuple[Body, Body]) -> float:
    """Return by how much the normal may turn while the contact lasts, rad."""
    relative = impact.before.velocity_b - impact.before.velocity_a
    across = float(np.linalg.norm(np.cross(impact.normal, relative)))
    lasts = 0.0 if impact.duration is None else impact.duration.value + impact.duration.sigma
    return max(NORMAL_TURNS, across * lasts / (bodies[0].radius + bodies[1].radius))
