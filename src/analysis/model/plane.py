"""Figure 7.4 of the thesis: surface velocity after contact against that before, over v_n."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import States, surface_velocity
from analysis.effects.contact.tangential_compliance import (
    LEAST_FRICTION,
    POISSON_RATIO,
    friction_reach,
    lever_of,
    maw_curve,
    walton_curve,
)
from analysis.model.agreement.outcome import Outcomes, outcomes
from analysis.model.data.stream import CampaignData, whole
from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit
from analysis.model.predict.contact import AFTER, contact_outcome
from analysis.model.rank.projector import projector
from analysis.model.structure.channels import contact_columns

LEAST_SPEED = 1e-3
CURVE = 200
CORNER_REACH = 2.4
"""The curves reach so many times the corner of the two lines at least."""


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """Shots and laws in the plane of v_s / |v_n| (x) and v_s' / |v_n| (y).

    Attributes
    ----------
    shots, x, y, sigma
        K shots whose surface velocity after contact is measured, shape (K,). `sigma` is the
        standard error of the height over the fitted law, both sides of the contact in it.
    e, mu, beta0
        Of the fit.
    law_x, walton, maw
        Walton's two lines, y = max(-beta0 x, x - mu (1 + e) (1 + 1/K)) (thesis, section 7.1), and
        the curve of Maw, Barber and Fawcett with the fit's e and mu, shape (C,).
    poisson_ratio
        Of that curve.
    """

    shots: NDArray[np.intp]
    x: Floats
    y: Floats
    sigma: Floats
    e: float
    mu: float
    beta0: float
    law_x: Floats
    walton: Floats
    maw: Floats
    poisson_ratio: float

    def to_json(self) -> dict[str, object]:
        """Return the same with arrays as lists."""
        found = {field.name: getattr(self, field.name) for field in fields(self)}
        return {
            name: value.tolist() if isinstance(value, np.ndarray) else value
            for name, value in found.items()
        }


def impact_plane(campaign: CampaignData, fit: Fit) -> Plane:
    """Place every shot in the plane: the law's rebound, and how far the poses lie from it."""
    data, states = whole(campaign), fit.states
    before = states.before
    surface = surface_velocity(before, states.normal, data.bodies)
    speed = np.maximum(np.linalg.norm(surface, axis=1), LEAST_SPEED)
    relative = before.velocity_b - before.velocity_a
    approach = np.maximum(-(relative * states.normal).sum(axis=1), LEAST_SPEED)
    leaving = contact_outcome(data, states, fit.theory)[:, AFTER].reshape(-1, 4, 3)
    after = States(*(leaving[:, k] for k in range(4)))
    foretold = surface_velocity(after, states.normal, data.bodies)
    along = (foretold * surface).sum(axis=1) / speed
    change, sigma, told = _surface_change(
        data, outcomes(projector(data, fit), contact_columns(data, states, fit.theory))
    )
    x = speed / approach
    law, lever = fit.theory.law, lever_of(data.bodies)
    corner = friction_reach(law, lever) / (1 + law.beta0)
    law_x = _places(corner, float(x.max()))
    return Plane(
        shots=data.shots[told],
        x=x[told],
        y=((along + change) / approach)[told],
        sigma=(sigma / approach)[told],
        e=law.e,
        mu=law.mu,
        beta0=law.beta0,
        law_x=law_x,
        walton=walton_curve(law, lever, law_x),
        maw=maw_curve(law.e, max(law.mu, LEAST_FRICTION), lever, law_x),
        poisson_ratio=POISSON_RATIO,
    )


def _surface_change(data: Data, found: Outcomes) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Return by how much the poses want v_s' changed, its error, and in which shots they tell.

    V_s = V_t + n x (R_a w_a + R_b w_b) along t: of the spins the part along b enters.
    """
    first, second = (body.radius for body in data.bodies)
    plate = data.bodies[1].is_plate
    weights = {
        "relative velocity t": 1.0,
        "common spin b": -(first + second),
        "relative spin b": -(second - first) * (1.0 if plate else 0.5),
    }
    row = np.array([weights.get(name, 0.0) for name in found.names])
    told = np.asarray(found.seen[:, row != 0].all(axis=1))
    variance = np.einsum("c,scd,d->s", row, found.covariance, row)
    return found.change @ row, np.sqrt(np.maximum(variance, 0.0)), told


def _places(corner: float, farthest: float) -> Floats:
    """Return where the curves are drawn: densely about the corner, and beyond all shots."""
    near = np.linspace(0.0, CORNER_REACH * corner, CURVE)
    end = max(1.05 * farthest, CORNER_REACH * corner)
    return np.unique(np.concatenate([near, [corner], np.linspace(near[-1], end, CURVE)]))
