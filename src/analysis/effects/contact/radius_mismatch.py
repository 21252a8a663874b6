"""Spheres whose radii are not the stated ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import Body, Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values

LEAST_SPEED = 1e-3
"""m/s; a slower approach to a plate would take for ever."""


def wrap(operator: Operator, values: Values) -> Operator:
    """Let the spheres touch, and the operator act, at (1 + d_a) R_a + (1 + d_b) R_b.

    The encounter is stated for the stated radii. True spheres of another size touch a little
    earlier or later on the same straight lines, with the line of centres turned accordingly. The
    normal of a plate stays.
    """

    def changed(encounter: Encounter) -> Outcome:
        bodies = tuple(
            _grown(body, 1.0 + float(d)) for body, d in zip(encounter.bodies, values, strict=True)
        )
        stated = sum(body.radius for body in encounter.bodies)
        true = sum(body.radius for body in bodies)
        before = encounter.before
        relative = before.velocity_b - before.velocity_a
        if encounter.bodies[1].is_plate:
            earlier = (true - stated) / encounter.approach.clip(min=LEAST_SPEED)
            back, normal = earlier[:, None], encounter.normal
        else:
            earlier = _earlier(encounter.approach, relative, stated, true)
            back = earlier[:, None]
            normal = encounter.normal * (stated / true) - relative * back / true
        outcome = operator(replace(encounter, normal=normal, bodies=(bodies[0], bodies[1])))
        return replace(
            outcome,
            duration=outcome.duration - earlier,
            shift_a=outcome.shift_a - before.velocity_a * back,
            shift_b=outcome.shift_b - before.velocity_b * back,
            turn_a=outcome.turn_a - before.spin_a * back,
            turn_b=outcome.turn_b - before.spin_b * back,
        )

    return changed


def _grown(body: Body, factor: float) -> Body:
    return Body(
        body.mass * factor**3, body.radius * factor, body.inertia * factor**5, body.material
    )


def _earlier(approach: Floats, relative: Floats, stated: float, true: float) -> Floats:
    """Return by how much earlier than at the stated distance the true one is passed, s.

    Of lines that never come as near as the true distance the nearest point is taken.
    """
    square = np.maximum((relative**2).sum(axis=1), 1e-12)
    along = stated * approach
    root = np.sqrt(np.maximum(along**2 + square * (true**2 - stated**2), 0.0))
    return np.asarray((root - np.abs(along)) / square)


def _parameter(sphere: str) -> Parameter:
    return Parameter(
        symbol=f"d_{sphere}",
        unit="1",
        meaning=f"share by which the radius of sphere {sphere} is larger than stated",
        plausible=(-0.005, 0.005),
    )


EFFECT = ContactEffect(
    name="radius-mismatch",
    title="Radius mismatch",
    parameters=(_parameter("a"), _parameter("b")),
    formula="R = (1 + d) R0, m = (1 + d)^3 m0, I = (1 + d)^5 I0: homogeneous, of stated density",
    source="geometry of touching spheres (thesis, eq. 5-37); one-inch balls keep 0.1 mm",
    gives_away="spheres kink with a gap or an overlap; spins and mean velocity change with it",
    confused_with=("image-scale", "mass-mismatch", "finite-contact"),
    wrap=wrap,
    of_pairs=True,
)
