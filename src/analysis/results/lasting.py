"""What a campaign's report says where its contacts last: e, mu and what else the contact has.

Walton's two lines are a law of contacts that take no time. Of those that last they say nothing
true: e falls with the obliquity, and the corner of stick and slip is round. How well a line goes
through a curve is no error of its slope, so that neither line has a number to be given.
"""

from __future__ import annotations

import numpy as np

from analysis.effects.contact.lasting_contact import EFFECT
from analysis.model.fitting.robust_fit import Judged, judged_with
from analysis.quantity import Quantity
from analysis.results.impacts import SHARED, Impacts
from analysis.results.lines import Lines
from analysis.results.ratios import ratios

LEAST_FALL = 36.0
"""Of chi-squared, in units of what is left: six standard errors."""
LEAST_SIGMAS = 5.0
"""By which the duration of a contact is to differ from none."""


def contacts_that_last(found: Judged, lines: Lines) -> Judged | None:
    """Return the fit of contacts that last; None where the two lines, or another law, may hold.

    It is made only where the shots contradict the two lines, and believed where it leaves far less
    unexplained than the operator of hard spheres does, at a duration that is measured and possible.
    """
    if lines.scatter == 1.0:
        return None
    other = judged_with(found, (EFFECT,))
    fit, noise = other.fit, other.fit.chi2_per_dof
    active = next((a for a in fit.theory.active if a.effect.name == EFFECT.name), None)
    if active is None or (found.fit.chi2_per_dof - noise) * fit.freedom < LEAST_FALL * noise:
        return None
    duration = fit.parameters()[f"{EFFECT.name}.t"]
    least, most = EFFECT.parameters[0].plausible
    certain = duration.determined and duration.value > LEAST_SIGMAS * duration.sigma
    return other if certain and least < duration.value < most else None


def mean_restitution(impacts: Impacts, used: np.ndarray) -> Quantity:
    """Return the mean e of some shots, mask of shape (S,), weighed by each shot's own errors.

    It is that of these shots and no constant of the spheres. What all shots share errs as in each.
    """
    chosen = impacts.of_shots(used & np.isfinite(ratios(impacts).e.value))
    each = ratios(chosen.apart()).e
    weight = 1.0 / each.sigma**2
    weight /= weight.sum()
    mean = float(weight @ each.value)
    common = 0.0
    if chosen.shared is not None:
        moved = [weight @ ratios(chosen.moved(k)).e.value - mean for k in range(SHARED)]
        common = float(np.linalg.norm(moved))
    own = float(np.sqrt(weight**2 @ each.sigma**2))
    return Quantity(mean, float(np.hypot(own, common)), "1", common)
