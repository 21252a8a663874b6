"""All results of a campaign: every shot's coefficients, the two lines, e against speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.effects.contact.lasting_contact import EFFECT
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.robust_fit import RobustFit, robust_fit, robust_fit_with
from analysis.quantity import Quantity
from analysis.results.from_poses import pose_impacts
from analysis.results.from_table import table_impacts
from analysis.results.impacts import SHARED, V_N, V_N_AFTER, Impacts, LeftOut
from analysis.results.lines import Lines, fit_lines
from analysis.results.ratios import Ratios, ratios

ITERATIONS = 200
SETTLED = 1e-14
LEAST_POINTS = 3


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """y = intercept + slope x.

    Attributes
    ----------
    slope, intercept
        In the units of the points.
    covariance
        Of (slope, intercept), as the points' errors give it, shape (2, 2).
    chi2, freedom
        Sum of the weighted squares of the residuals, and points less two.
    """

    slope: float
    intercept: float
    covariance: Floats
    chi2: float
    freedom: int

    def at(self, x: Floats) -> Floats:
        """Return the line's height."""
        return np.asarray(self.intercept + self.slope * x)

    def sigma_at(self, x: Floats) -> Floats:
        """Return the standard error of the line's height."""
        design = np.stack([x, np.ones_like(x)], axis=-1)
        return np.asarray(np.sqrt(np.einsum("...i,ij,...j", design, self.covariance, design)))


def york_line(
    x: Floats, y: Floats, sigma_x: Floats, sigma_y: Floats, correlation: Floats
) -> Line | None:
    """Fit the line that makes the true points' errors most likely.

    Minimises sum (y - a - b x)^2 / (sigma_y^2 + b^2 sigma_x^2 - 2 b r sigma_x sigma_y) over a and
    b, the true places along the line eliminated. D. York, N. M. Evensen, M. Lopez Martinez and
    J. De Basabe Delgado, Am. J. Phys. 72, 367 (2004), equations (13) for line and errors.

    Parameters
    ----------
    x, y, sigma_x, sigma_y, correlation
        Points, their standard errors, and the correlation of these, shape (N,).

    Returns
    -------
    None with fewer than three points, or where they all stand at one place.
    """
    if len(x) < LEAST_POINTS or np.ptp(x) == 0:
        return None
    slope = float(np.polyfit(x, y, 1)[0])
    for _ in range(ITERATIONS):
        weight, middle, adjusted = _adjusted(slope, (x, y), (sigma_x, sigma_y), correlation)
        better = float(
            (weight * adjusted * middle[1]).sum() / (weight * adjusted * middle[0]).sum()
        )
        done = abs(better - slope) <= SETTLED * max(abs(slope), 1.0)
        slope = better
        if done:
            break
    weight, middle, adjusted = _adjusted(slope, (x, y), (sigma_x, sigma_y), correlation)
    x_mean, y_mean = ((weight * part).sum() / weight.sum() for part in (x, y))
    intercept = float(y_mean - slope * x_mean)
    place = x_mean + adjusted
    centre = float((weight * place).sum() / weight.sum())
    variance = 1.0 / float((weight * (place - centre) ** 2).sum())
    covariance = variance * np.array([[1.0, -centre], [-centre, centre**2]])
    covariance[1, 1] += 1.0 / float(weight.sum())
    chi2 = float((weight * (y - intercept - slope * x) ** 2).sum())
    return Line(slope, intercept, covariance, chi2, len(x) - 2)


def _adjusted(
    slope: float, points: tuple[Floats, Floats], sigmas: tuple[Floats, Floats], correlation: Floats
) -> tuple[Floats, tuple[Floats, Floats], Floats]:
    """Return weights, distances from the weighted mean, and adjusted places less that mean."""
    (x, y), (sigma_x, sigma_y) = points, sigmas
    shared = correlation * sigma_x * sigma_y
    weight = 1.0 / (sigma_y**2 + slope**2 * sigma_x**2 - 2 * slope * shared)
    u = x - (weight * x).sum() / weight.sum()
    v = y - (weight * y).sum() / weight.sum()
    adjusted = weight * (u * sigma_y**2 + slope * v * sigma_x**2 - (slope * u + v) * shared)
    return weight, (u, v), adjusted


def speed_line(impacts: Impacts, found: Ratios, used: NDArray[np.bool_]) -> Line | None:
    """Fit e = e_0 + slope |v_n|, errors of both and their correlation by the shared v_n.

    A line is the first order of whatever law holds over the speeds of a campaign; slope in s/m.
    None where the shots do not determine one. `used`, shape (S,), marks the shots that count.
    """
    sigma_speed = np.sqrt(impacts.covariance[:, V_N, V_N])
    columns = (
        *(impacts.approach, found.e.value, sigma_speed, found.e.sigma),
        _correlation(impacts, found),
    )
    return york_line(*(column[used] for column in columns))


def _correlation(impacts: Impacts, found: Ratios) -> Floats:
    """Return the correlation of the errors of |v_n| and e = v_n' / |v_n|, shape (S,)."""
    v, c = impacts.approach, impacts.covariance
    # With |v_n| = -v_n: cov(|v_n|, e) = -cov(v_n, v_n') / |v_n| - e var(v_n) / |v_n|.
    shared = -(c[:, V_N, V_N_AFTER] + found.e.value * c[:, V_N, V_N]) / v
    spread = np.sqrt(c[:, V_N, V_N]) * found.e.sigma
    return np.asarray(np.where(spread > 0, shared / np.where(spread > 0, spread, 1.0), 0.0))


LEAST_FALL = 36.0
"""Of chi-squared, in units of what is left: six standard errors."""
LEAST_SIGMAS = 5.0
"""By which the duration of a contact is to differ from none."""


def contacts_that_last(found: RobustFit, lines: Lines) -> RobustFit | None:
    """Return the fit with contacts of finite duration; None where another law may hold.

    It is made only where the shots contradict the two lines, and returned where its chi-squared is
    far below that of the hard-sphere operator, at a duration that is measured and possible.
    """
    if lines.scatter == 1.0:
        return None
    other = robust_fit_with(found, (EFFECT,))
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


NO_BOTH = "too few frames show both spheres before the contact or after it"
NO_FLIGHTS = "too few frames show the sphere free before its bounce, or after it"
"""Of a sphere on a plate."""


@dataclass(frozen=True, slots=True, eq=False)
class Results:
    """The thesis's results for a campaign.

    Attributes
    ----------
    impacts, ratios
        What each shot measured, and its coefficients.
    lines
        The regression for e, mu and beta0.
    speed
        e against approach speed; None where the shots do not determine a line.
    whole_fit
        The parameters of the law that was fitted to all poses, or all tabulated numbers: e, mu and
        beta0 of the hard-sphere operator; of contacts that last e, mu and theirs.
    lasting
        Whether the contacts last: the two lines are no law of theirs, and e is the shots' mean.
    left_out
        Shots of which no impact was measured.
    far
        Shots that were measured, and that the regression does not use.
    remarks
        What the fit to all that was measured did not take as stated.
    """

    impacts: Impacts
    ratios: Ratios
    lines: Lines
    speed: Line | None
    whole_fit: Mapping[str, Quantity]
    left_out: tuple[LeftOut, ...]
    far: tuple[LeftOut, ...]
    remarks: tuple[str, ...]
    lasting: bool = False

    def coefficients(self) -> dict[str, Quantity]:
        """Return e, mu and beta0 of the regression, as far as these shots have them."""
        if self.lasting:
            return {"e": mean_restitution(self.impacts, self.lines.used)}
        return self.lines.parameters()


def results(data: Data, measured: Impacts | None = None) -> Results:
    """Measure all impacts of a campaign and fit what they follow.

    Parameters
    ----------
    measured
        The impacts, where they were measured of more than the data hold.

    Raises
    ------
    TooFewShotsError
        No shot has a measured impact.
    """
    found = robust_fit(data)
    impacts = _impacts(data, found) if measured is None else measured
    unusable = unusable_shots(found.evidence.stated, impacts)
    each, lines = ratios(impacts), fit_lines(impacts)
    other = contacts_that_last(found, lines)
    fitted = found if other is None else other
    return Results(
        impacts=impacts,
        ratios=each,
        lines=lines,
        speed=speed_line(impacts, each, lines.used),
        whole_fit=fitted.fit.parameters(),
        left_out=tuple(sorted([*unusable, *impacts.left_out], key=lambda one: one.shot)),
        far=_far(impacts, lines),
        remarks=tuple(fitted.remarks()),
        lasting=other is not None,
    )


def unusable_shots(data: CampaignData, impacts: Impacts) -> list[LeftOut]:
    """Return the shots that are not among the data, and of which no impact was measured either."""
    reason = NO_FLIGHTS if data.bodies[1].is_plate else NO_BOTH
    missing = sorted(set(data.unusable) - set(impacts.shots.tolist()))
    return [LeftOut(number, reason) for number in missing]


def _far(impacts: Impacts, lines: Lines) -> tuple[LeftOut, ...]:
    return tuple(
        LeftOut(
            int(impacts.shots[row]),
            f"measured, but {np.sqrt(lines.held.chi2[row]):.0f} standard errors from both lines: "
            "not in the regression; look for a marker that took another's name",
        )
        for row in np.flatnonzero(~lines.used)
    )


def _impacts(data: Data, found: RobustFit) -> Impacts:
    """Measure the impacts of all shots, also of those that the fit to all poses leaves out.

    That fit drops shots and frames which are unlike its law; here no law may choose.
    """
    if isinstance(data, PoseData):
        return pose_impacts(data)
    stated = found.evidence.stated
    assert isinstance(stated, ContactTable)  # noqa: S101
    return table_impacts(stated)
