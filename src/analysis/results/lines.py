"""The regression of section 7.1: e, mu and beta0 from the two lines, whatever shot lies on which.

The likelihood of `analysis.results.likelihood` is maximised. Where only one regime is seen its own
parameter is fitted and the other one is not given: a second line must lower chi-squared by more
than chance and its freedom explain. Shots far from both lines do not count; they are named.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis import chi_squared
from analysis.arrays import Floats
from analysis.birge import variance_ratio
from analysis.collision.operator import WaltonLaw
from analysis.effects.contact.tangential_compliance import friction_reach, walton_curve
from analysis.quantity import Quantity
from analysis.results.impacts import SHARED, V_N, V_N_AFTER, V_S, V_S_AFTER, Impacts
from analysis.results.likelihood import Likelihood, likelihood

NAMES = ("e", "mu", "beta0")
LEAST_GAIN = 12.0
"""By which a second regime must lower chi-squared: one more parameter, and any shot may begin it
(1 in 500 by chance among 30 shots)."""
NO_SLIDING, NO_STICKING = 10.0, 1.0
"""mu and beta0 that put the transition beyond all shots, and as near zero as a contact can."""
FAR, MOST_FAR = 10.0, 0.15
"""Standard errors, times the scatter of the median shot, beyond which a shot does not count: a
marker took another's name. If more shots than this share lie there it is physics, and all do."""
LEAST_SQUARE = 1e-18
"""(m/s)^2, far below any error."""
LEAST_CURVATURE = 1e-6
"""Of the likelihood in these units: a parameter that is flatter is not determined."""
UNITS = np.array([1e-3, 1e-3, 1e-2])
"""About the errors that a campaign gives e, mu and beta0: units of the search."""
STEP = 0.01
"""Of the derivatives, in the units of the numbers."""
ROUNDS, HALVINGS = 60, 12
SETTLED = 1e-8
FLATTEST = 1e-9
"""Of the largest curvature: a flatter direction is not followed."""


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """The regression of a campaign.

    Attributes
    ----------
    law
        e, mu, beta0; one that these shots do not determine is at a bound and not `fitted`.
    fitted
        Names of what the shots determine.
    covariance
        Of these, in their order, as the shots' own errors give it.
    held
        All shots against this law.
    used
        Which of them the fit used, shape (S,).
    chi2, freedom
        -2 log likelihood, and measured constraints less fitted parameters, of those.
    shared
        Part of the covariance from errors that all shots share; no scatter shows it.
    """

    law: WaltonLaw
    fitted: tuple[str, ...]
    covariance: Floats
    held: Likelihood
    used: NDArray[np.bool_]
    chi2: float
    freedom: int
    shared: Floats

    @property
    def p_value(self) -> float:
        """Return the p-value of the scatter, by the shots' own errors."""
        return float(chi_squared.chance_of_more(self.chi2, self.freedom))

    @property
    def scatter(self) -> float:
        """Return the Birge ratio: root of chi-squared per degree of freedom, enlarging errors.

        1 while the shots' own errors explain the scatter (`birge.variance_ratio`).
        """
        return float(np.sqrt(variance_ratio(self.chi2, self.freedom)))

    @property
    def determined(self) -> bool:
        """Whether the shots determine everything that was fitted."""
        return bool(np.isfinite(self.covariance).all())

    def parameters(self) -> dict[str, Quantity]:
        """Return the determined parameters, the shots' own errors enlarged by the Birge ratio."""
        whole = self.scatter**2 * self.covariance + self.shared
        sigma, common = np.sqrt(np.diag(whole)), np.sqrt(np.diag(self.shared))
        return {
            name: Quantity(getattr(self.law, name), float(s), "1", float(c))
            for name, s, c in zip(self.fitted, sigma, common, strict=True)
        }


class TooFewShotsError(ValueError):
    """No shot has a measured impact."""


def fit_lines(impacts: Impacts) -> Lines:
    """Fit e, mu and beta0 to all impacts.

    Shots are weighed by what each errs by itself; what an error that all share does to the whole
    is added to the errors of the result.

    Raises
    ------
    TooFewShotsError
        There is no impact.
    """
    if len(impacts.shots) == 0:
        raise TooFewShotsError("no shot of this campaign has a measured impact")
    own = impacts.apart()
    first = _of_all(own)
    near = ~_far(first)
    if near.all():
        return _with_shared(first, own)
    second = _of_all(own.of_shots(near))
    known = own if len(second.fitted) > 1 else own.without_surface()
    held = replace(second, held=likelihood(known, second.law), used=near)
    return _with_shared(held, own)


def _with_shared(found: Lines, own: Impacts) -> Lines:
    """Add what each shared error, one standard error of it, does to the fit."""
    if own.shared is None or not found.determined:
        return found
    used = own.of_shots(found.used)
    known = used if len(found.fitted) > 1 else used.without_surface()
    shared = np.zeros_like(found.covariance)
    here = np.array([getattr(found.law, name) for name in found.fitted])
    for error in range(SHARED):
        law = _fitted(known.moved(error), found.law, found.fitted).law
        change = np.array([getattr(law, name) for name in found.fitted]) - here
        shared += np.outer(change, change)
    return replace(found, shared=shared)


def _far(found: Lines) -> NDArray[np.bool_]:
    """Return which shots lie too far from both lines, shape (S,)."""
    chi2 = found.held.chi2
    typical = max(1.0, float(np.median(chi2)) / float(chi_squared.median(2)))
    far = np.asarray(chi2 > FAR**2 * typical)
    return far if far.sum() <= MOST_FAR * len(far) else np.zeros_like(far)


def _of_all(impacts: Impacts) -> Lines:
    """Fit the regimes that the shots show."""
    e = _restitution(impacts)
    if not impacts.surface.any():
        return _fitted(impacts, WaltonLaw(e, NO_SLIDING, 0.0), ("e",))
    friction, beta0, both = _starts(impacts, e)
    stick = _fitted(impacts, WaltonLaw(e, NO_SLIDING, beta0), ("e", "beta0"))
    slide = _fitted(impacts, WaltonLaw(e, friction, NO_STICKING), ("e", "mu"))
    single = _of_one_regime(impacts, stick, slide)
    if both is None:
        return single
    double = _fitted(impacts, both, NAMES)
    gains = double.chi2 + LEAST_GAIN < min(stick.chi2, slide.chi2)
    return double if gains and double.determined else single


def _of_one_regime(impacts: Impacts, stick: Lines, slide: Lines) -> Lines:
    """Return the regime in which all shots lie.

    Shots at one setting lie on either line. Those that go on in their direction have slid; those
    whose surface velocity is reversed may have done either; they determine restitution alone.
    """
    better = stick if stick.chi2 < slide.chi2 else slide
    if abs(stick.chi2 - slide.chi2) > LEAST_GAIN and better.determined:
        return better
    if stick.determined and slide.determined and stick.law.beta0 < 0:
        return slide
    return _fitted(impacts.without_surface(), WaltonLaw(stick.law.e, 0.0, 0.0), ("e",))


def _restitution(impacts: Impacts) -> float:
    """Return e of all shots, weighted by errors at a first guess: where the search begins."""
    before, after = impacts.velocities[:, V_N], impacts.velocities[:, V_N_AFTER]
    guess = float(np.median(-after / before))
    row = np.zeros(4)
    row[[V_N, V_N_AFTER]] = guess, 1.0
    weight = 1.0 / np.einsum("i,sij,j->s", row, impacts.covariance, row)
    return float(-(weight * before * after).sum() / (weight * before**2).sum())


def _starts(impacts: Impacts, e: float) -> tuple[float, float, WaltonLaw | None]:
    """Return mu if all slide, beta0 if all stick, and the law at the best place of a transition.

    Every place between two shots in the order of v_s / |v_n| is tried, both lines fitted on their
    sides by sums that run along.
    """
    v = impacts.velocities[impacts.surface]
    v = v[np.argsort(-v[:, V_S] / v[:, V_N])]
    n, s, after = -v[:, V_N], v[:, V_S], v[:, V_S_AFTER]
    lost = s - after
    # A head-on shot may have no surface velocity at all.
    stick = [np.cumsum(part) for part in (s * s + LEAST_SQUARE, s * after, after * after)]
    slide = [np.cumsum(part[::-1])[::-1] for part in (n * n, n * lost, lost * lost)]
    per_friction = (1 + e) * impacts.lever
    mu = float(slide[1][0] / slide[0][0] / per_friction)
    beta0 = float(-stick[1][-1] / stick[0][-1])
    if len(v) < 2:
        return mu, beta0, None
    below = stick[2][:-1] - stick[1][:-1] ** 2 / stick[0][:-1]
    beyond = slide[2][1:] - slide[1][1:] ** 2 / slide[0][1:]
    best = int(np.argmin(below + beyond))
    law = WaltonLaw(
        e,
        float(slide[1][best + 1] / slide[0][best + 1] / per_friction),
        float(-stick[1][best] / stick[0][best]),
    )
    return mu, beta0, law if friction_reach(law, impacts.lever) > 0 else None


def _fitted(impacts: Impacts, start: WaltonLaw, names: tuple[str, ...]) -> Lines:
    """Minimise -2 log likelihood over some of the parameters."""
    where = [NAMES.index(name) for name in names]
    base, unit = np.array([start.e, start.mu, start.beta0])[where], UNITS[where]

    def law_at(step: Floats) -> WaltonLaw:
        values = map(float, base + unit * step)
        return replace(start, **dict(zip(names, values, strict=True)))

    def cost(step: Floats) -> float:
        return float(likelihood(impacts, law_at(step)).chi2.sum())

    step, curvature = _minimum(cost, len(where))
    flat = np.linalg.eigvalsh(curvature).min() < LEAST_CURVATURE
    inverse = np.full_like(curvature, np.inf) if flat else np.linalg.inv(curvature)
    law = law_at(step)
    held = likelihood(impacts, law)
    values = len(impacts.shots) + int(impacts.surface.sum())
    return Lines(
        law=law,
        fitted=names,
        covariance=np.asarray(2 * inverse * np.outer(unit, unit)),
        held=held,
        used=np.ones(len(impacts.shots), dtype=np.bool_),
        chi2=float(held.chi2.sum()),
        freedom=values - len(names),
        shared=np.zeros_like(curvature),
    )


def regression_curve(found: Lines, lever: float, x: Floats) -> Floats:
    """Return the same of a regression, with the lines alone that its shots determine."""
    if "mu" not in found.fitted:
        return np.asarray(
            -found.law.beta0 * x if "beta0" in found.fitted else np.full_like(x, np.nan)
        )
    if "beta0" not in found.fitted:
        return np.asarray(x - friction_reach(found.law, lever))
    return walton_curve(found.law, lever, x)


def _minimum(cost: Callable[[Floats], float], size: int) -> tuple[Floats, Floats]:
    """Search from zero by Newton's method, derivatives by central differences.

    Parameters
    ----------
    cost
        Its numbers in units in which its curvature is of the order of one.
    size
        How many numbers it has.

    Returns
    -------
    Where the search comes to rest, shape (size,), and the second derivatives there, (size, size).
    """
    place = np.zeros(size)
    here = cost(place)
    for _ in range(ROUNDS):
        slope, curvature = _derivatives(cost, place, here)
        values, vectors = np.linalg.eigh(curvature)
        steep = np.maximum(np.abs(values), FLATTEST * max(np.abs(values).max(), 1e-300))
        step = -vectors @ ((vectors.T @ slope) / steep)
        there = here
        for _ in range(HALVINGS):
            there = cost(place + step)
            if there <= here:
                break
            step = step / 2
        if not there <= here:
            break
        place, fall, here = place + step, here - there, there
        if fall <= SETTLED:
            break
    return place, _derivatives(cost, place, here)[1]


def _derivatives(
    cost: Callable[[Floats], float], place: Floats, here: float
) -> tuple[Floats, Floats]:
    """Return slope and curvature."""
    size = len(place)
    axes = STEP * np.eye(size)
    up, down = (np.array([cost(place + sign * axis) for axis in axes]) for sign in (1, -1))
    slope = (up - down) / (2 * STEP)
    curvature = np.diag(up + down - 2 * here)
    for i in range(size):
        for j in range(i):
            mixed = cost(place + axes[i] + axes[j]) + cost(place - axes[i] - axes[j])
            mixed += 2 * here - up[i] - down[i] - up[j] - down[j]
            curvature[i, j] = curvature[j, i] = mixed / 2
    return slope, curvature / STEP**2
