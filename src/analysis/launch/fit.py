"""Fitting the launches of a campaign: from the settings to the spheres at their mouths.

Generalised least squares. The fitted state at first touch is traced back to the mouths of the
tubes, where the quantities of a launch scatter independently, and compared with the prediction from
the settings. With B the derivative of the muzzle by the touch,

    covariance of a residual = B C B' + diag(s^2)

C is that of the measurement, s the scatter of each kind of quantity, estimated from the residuals
in turn with the parameters. The lengths `mouth` and `push` act on both sides: the right ones leave
slopes, offsets and lags that do not follow the speeds by which each shot happens to differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis import chi_squared
from analysis.arrays import Floats
from analysis.effects.effect import LaunchEffect
from analysis.effects.launch.pressure_friction import EFFECT as FRICTION
from analysis.errors import LaunchRefusedError
from analysis.launch.compared import Compared, compare, residual_at_mouths
from analysis.launch.measurement import Touches, measured_touches
from analysis.launch.muzzle import LaunchLaw
from analysis.launch.result import LaunchFit
from analysis.launch.scatter import KINDS, scatter_shape, variance_component
from analysis.launch.settings import LaunchSettings, settings_of
from analysis.launch.theory import LaunchTheory
from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.normal import inverse
from analysis.model.loops.blocks import whitened

FEWEST_SHOTS = 5
ROUNDS = 40
SETTLED, NEARLY_SETTLED = 1e-3, 0.02
"""A step below this share of every standard error ends the fit, if the scatter stays as well; the
second is enough to tell misfires."""
BETWEEN_JUMPS, NEARING = 4, 0.9
"""Scatters from which the limit of a row of rounds is taken, and the largest ratio of two changes
that follow each other for which it is."""
SHARES = (1.0, 0.5, 0.2, 0.05)
REJECTIONS, ALARM_SHARE, PHYSICS_SHARE = 4, 0.005, 0.15
ENOUGH_TO_BEGIN = 200
"""Shots spread over the campaign, to which the theory is fitted first."""
SLACK = 1e-6
"""Rise of the cost that is rounding."""


def fit_launch(
    data: Data,
    fit: Fit,
    effects: Sequence[LaunchEffect] = (FRICTION,),
    *,
    settings: LaunchSettings | None = None,
) -> LaunchFit:
    """Fit the launches to the states that a fit of the poses found; leave out misfires.

    Parameters
    ----------
    effects
        Launch effects to be fitted; by default the friction of the pushers, which no rig is
        without.
    settings
        Of the shots of `data`, in their order; None: what the covariates hold.

    Raises
    ------
    LaunchRefusedError
        Settings are missing, a pressure is not above zero, or the shots are fewer than five.
    """
    known = settings_of(data) if settings is None else settings
    return fit_touches(measured_touches(data, fit), known, effects)


def fit_touches(
    touches: Touches, settings: LaunchSettings, effects: Sequence[LaunchEffect] = (FRICTION,)
) -> LaunchFit:
    """Fit the launches to measured touches, shots in the same order; leave out misfires.

    Raises
    ------
    LaunchRefusedError
        As of `fit_launch`.
    """
    if len(touches.rows) < FEWEST_SHOTS:
        raise LaunchRefusedError(f"{len(touches.rows)} shots, {FEWEST_SHOTS} are needed")
    if (settings.pressure_kpa <= 0).any():
        raise LaunchRefusedError(
            f"a pressure of {settings.pressure_kpa.min():g} kPa, every one must be above 0"
        )
    theory = LaunchTheory(_first_law(settings, touches))
    for effect in effects:
        theory = theory.with_effect(effect)
    kept = np.ones(len(touches.rows), dtype=np.bool_)
    some = np.arange(len(kept)) % int(np.ceil(len(kept) / ENOUGH_TO_BEGIN)) == 0
    if not some.all():
        few = settings.of_shots(some), touches.of_shots(some)
        theory = _settle(theory, *few, NEARLY_SETTLED).theory
    launch = _settle(theory, settings, touches, NEARLY_SETTLED)
    for _ in range(REJECTIONS):
        bad = misfires(launch, int((~kept).sum()))
        if not bad.any() or (kept.sum() - bad.sum()) < FEWEST_SHOTS:
            break
        kept[np.flatnonzero(kept)[bad]] = False
        left = settings.of_shots(kept), touches.of_shots(kept)
        launch = _settle(launch.theory, *left, NEARLY_SETTLED)
    launch = _settle(launch.theory, launch.settings, launch.touches)
    return replace(launch, rejected=touches.shots[~kept])


def settled(theory: LaunchTheory, known: LaunchFit) -> LaunchFit:
    """Fit another theory to the launches of a fit; the shots that it left out stay out."""
    return replace(_settle(theory, known.settings, known.touches), rejected=known.rejected)


def misfires(launch: LaunchFit, before: int = 0) -> NDArray[np.bool_]:
    """Return which shots no launch like the others would give, mask of shape (S,).

    Chi-squared of a shot's 17 numbers, scatter in their errors, against the quantile that one
    campaign in 200 without misfires exceeds. Where more than 15 % of the shots do, it is the
    theory that fails, and none is named.

    Parameters
    ----------
    before
        Shots that were rejected already; they count in the share.
    """
    residual, _ = launch.compared.whitened(launch.scatter)
    squares = (residual**2).sum(axis=1)
    shots = len(squares)
    bad = np.asarray(squares > chi_squared.limit(ALARM_SHARE / shots, residual.shape[1]))
    physics = bad.sum() + before > PHYSICS_SHARE * (shots + before)
    return np.zeros_like(bad) if physics else bad


def _first_law(settings: LaunchSettings, touches: Touches) -> LaunchLaw:
    """Return pushers with the gain of the median shot."""
    speeds = np.abs(touches.rows[:, [1, 4]])
    gain = np.median(speeds**2 / settings.pressure_kpa, axis=0)
    return LaunchLaw(float(gain[0]), float(gain[1]))


def _settle(
    theory: LaunchTheory, settings: LaunchSettings, touches: Touches, within: float = SETTLED
) -> LaunchFit:
    """Step the parameters and estimate the scatter in turn until both stay within a share."""
    compared, freedom = compare(theory, settings, touches), _all_free(len(touches.rows))
    scatter, covariance = _scatter(compared, freedom), np.zeros((0, 0))
    converged, traced = False, True
    since = [scatter]
    for _ in range(ROUNDS):
        matrix, gradient = _sums(theory, compared, scatter)
        covariance = inverse(matrix)
        step = covariance @ gradient
        theory, compared = _step(theory, step, (compared, scatter), settings, touches)
        freedom = _freedom(compared, scatter, covariance)
        before, scatter = scatter, _scatter(compared, freedom)
        since.append(scatter)
        still = np.abs(scatter - before) <= within * np.maximum(scatter, 1e-12)
        small = np.abs(step) <= within * np.sqrt(np.diag(covariance))
        converged = bool(still.all() and small.all())
        if converged and traced:
            break
        if len(since) == BETWEEN_JUMPS:
            scatter = _limit(since)
            since = [scatter]
        # Errors are traced back by a theory of an earlier round, until it hardly moves any more.
        traced = converged
        if traced:
            compared = compare(theory, settings, touches)
    return LaunchFit(
        theory=theory,
        covariance=covariance,
        scatter=scatter,
        freedom=freedom,
        compared=compared,
        settings=settings,
        touches=touches,
        rejected=touches.shots[:0],
        converged=converged,
    )


def _limit(since: Sequence[Floats]) -> Floats:
    """Return where rounds take a scatter that nears it by the same share in each.

    A. C. Aitken, Proc. R. Soc. Edinb. 46, 289 (1926). Kinds that do not near anything stay.
    """
    older, old, scatter = since[-3:]
    first, second = old - older, scatter - old
    nearing = (first * second > 0) & (np.abs(second) < NEARING * np.abs(first))
    rest = np.divide(second**2, first - second, out=np.zeros_like(second), where=nearing)
    return np.asarray(np.maximum(scatter + rest, 0.0))


def _step(
    theory: LaunchTheory,
    step: Floats,
    present: tuple[Compared, Floats],
    settings: LaunchSettings,
    touches: Touches,
) -> tuple[LaunchTheory, Compared]:
    """Take the longest share of a step that does not raise the cost; none: stay."""
    compared, scatter = present
    variance = compared.variance(scatter)
    cost = _cost(theory, compared.residual, variance)
    for share in SHARES:
        moved = theory.at(theory.vector + share * step)
        residual = residual_at_mouths(moved, settings, touches)
        # The weights stay: costs by different weights could not be compared.
        if _cost(moved, residual, variance) <= cost + SLACK:
            return moved, compare(moved, settings, touches, compared.covariance)
    return theory, compared


def _cost(theory: LaunchTheory, residual: Floats, variance: Floats) -> float:
    """Return chi-squared of residuals (S, 17) at a fixed variance, with the prior."""
    centre, width = theory.prior
    squares = whitened(variance, residual[..., None]) ** 2
    return float(squares.sum() + (((theory.vector - centre) / width) ** 2).sum())


def _sums(theory: LaunchTheory, compared: Compared, scatter: Floats) -> tuple[Floats, Floats]:
    """Return the information matrix and the gradient downhill, the prior in."""
    residual, derivative = compared.whitened(scatter)
    flat = derivative.reshape(-1, derivative.shape[-1])
    centre, width = theory.prior
    matrix = flat.T @ flat + np.diag(width**-2)
    gradient = flat.T @ residual.reshape(-1) - (theory.vector - centre) / width**2
    return matrix, np.asarray(gradient)


def _all_free(shots: int) -> Floats:
    return np.array([float(shots * len(kind.columns)) for kind in KINDS])


def _freedom(compared: Compared, scatter: Floats, covariance: Floats) -> Floats:
    """Return the degrees of freedom of each kind: its numbers less its share of the hat matrix."""
    residual, derivative = compared.whitened(scatter)
    leverage = ((derivative @ covariance) * derivative).sum(axis=2)
    shots = len(residual)
    taken = np.array([leverage[:, list(kind.columns)].sum() for kind in KINDS])
    return np.asarray(np.maximum(_all_free(shots) - taken, 1.0))


def _scatter(compared: Compared, freedom: Floats) -> Floats:
    """Return the scatter of each kind from its own residuals, shape (K,)."""
    found = []
    variance = np.diagonal(compared.covariance, axis1=1, axis2=2)
    for kind, nu in zip(KINDS, freedom, strict=True):
        columns = list(kind.columns)
        shape = np.concatenate([scatter_shape(c, compared.speed) for c in columns])
        residual = compared.residual[:, columns].T.reshape(-1)
        found.append(
            variance_component(residual, variance[:, columns].T.reshape(-1), shape, float(nu))
        )
    return np.array(found)
