"""From the rows of contacts.csv or impacts.csv to the arrays that are fitted, and their noise.

Noise that a table does not state is found channel by channel, from the scatter about the law.
Velocities and spins of contacts, normal and surface velocities of impacts have a scale each, so
that good normal velocities are not buried under bad spins.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from analysis import chi_squared
from analysis.arrays import Floats
from analysis.collision.operator import Body, States
from analysis.exchange.contact_table import ContactRow
from analysis.exchange.impact_table import ImpactRow
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.predict.comparison import compare
from analysis.model.predict.sides import NUMBERS, place_of_rate
from analysis.model.predict.state import MOTION, SIZE
from analysis.model.predict.theory import Theory

FIRST_GUESS = 0.01
"""m/s: the scale of errors that are not stated, before it is estimated."""
NORMAL, ALONG = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
"""Directions that stand for every normal and incident surface velocity where scalars are given."""


def contacts_table(
    rows: Sequence[ContactRow],
    bodies: tuple[Body, Body],
    covariates: Mapping[str, Floats],
    gravity: float,
) -> ContactTable:
    """Put full states before and after contact into arrays: 24 numbers a shot.

    Where a duration was measured it is the 25th.

    Parameters
    ----------
    covariates
        Each of shape (S,), in the order of the rows.
    gravity
        m/s^2 along +X.
    """
    before, after = (np.array([getattr(row, k) for row in rows]) for k in ("before", "after"))
    numbers = np.concatenate([before, after], axis=1)
    estimated = all(sigma is None for row in rows for sigma in row.errors)
    sigma = np.array([_contact_sigmas(row, bodies, estimated=estimated) for row in rows])
    sigma[np.isnan(numbers)] = np.inf
    # What a spin became says nothing where it is not known what it was.
    unknown = np.isnan(before[:, 6:]).reshape(-1, 2, 3).any(axis=2)
    for spins in (sigma[:, 6:12], sigma[:, 18:24]):
        spins[np.repeat(unknown, 3, axis=1)] = np.inf
    before, functional = np.nan_to_num(before), _all_rates()
    if lasts := any(row.duration_s is not None for row in rows):
        functional = np.concatenate([functional, np.zeros((1, NUMBERS))])
        numbers, sigma = (
            np.column_stack([first, [np.nan if own is None else own for own in last]])
            for first, last in (
                (numbers, [row.duration_s for row in rows]),
                (sigma, [_or_infinite(row.sigma_duration_s) for row in rows]),
            )
        )
    return ContactTable(
        shots=np.array([row.shot for row in rows], dtype=np.intp),
        normal=np.array([row.normal for row in rows]),
        start=States(before[:, :3], before[:, 3:6], before[:, 6:9], before[:, 9:]),
        numbers=np.nan_to_num(numbers),
        sigma=sigma,
        functional=functional,
        after=np.arange(len(functional)) >= 12,
        open=_open(bodies, scalars=False),
        bodies=bodies,
        gravity=gravity,
        covariates=covariates,
        scalars=False,
        estimated=estimated,
        lasts=lasts,
    )


def impacts_table(
    rows: Sequence[ImpactRow],
    bodies: tuple[Body, Body],
    covariates: Mapping[str, Floats],
    gravity: float,
) -> ContactTable:
    """Put the scalars of impacts into arrays: v_n, v_s, v_n', v_s' of each shot.

    How the relative velocity is shared by the bodies, and v_s by velocity and spin, the scalars do
    not say and need not: half and half, and no spin, is where the fit starts.

    Parameters
    ----------
    covariates
        Each of shape (S,), in the order of the rows.
    gravity
        m/s^2 along +X.
    """
    numbers = np.array([row.speeds for row in rows])
    estimated = all(s is None for row in rows for s in row.sigmas)
    sigma = np.array(
        [[_or_infinite(FIRST_GUESS if estimated else s) for s in row.sigmas] for row in rows]
    )
    # v_s' tells of friction only beside the v_s that it comes from.
    numbers[np.isnan(numbers[:, 1]), 3] = np.nan
    sigma[np.isnan(numbers)] = np.inf
    numbers = np.nan_to_num(numbers)
    relative = numbers[:, :1] * NORMAL + numbers[:, 1:2] * ALONG
    share = 1.0 if bodies[1].is_plate else 0.5
    still = np.zeros_like(relative)
    return ContactTable(
        shots=np.array([row.shot for row in rows], dtype=np.intp),
        normal=np.tile(NORMAL, (len(rows), 1)),
        start=States(-share * relative, (1 - share) * relative, still, still),
        numbers=numbers,
        sigma=sigma,
        functional=_scalars(bodies),
        after=np.array([False, False, True, True]),
        open=_open(bodies, scalars=True),
        bodies=bodies,
        gravity=gravity,
        covariates=covariates,
        scalars=True,
        estimated=estimated,
    )


def _contact_sigmas(row: ContactRow, bodies: tuple[Body, Body], *, estimated: bool) -> Floats:
    """Return the sigmas of the 24 numbers; a plate at rest is not measured."""
    if estimated:
        spin = FIRST_GUESS / bodies[0].radius
        sigma = np.tile(np.repeat([FIRST_GUESS, spin], 6), 2)
    else:
        sigma = np.array([_or_infinite(own) for own in row.errors])
    if bodies[1].is_plate:
        sigma.reshape(4, 2, 3)[:, 1] = np.inf
    return sigma


def _or_infinite(sigma: float | None) -> float:
    return np.inf if sigma is None else sigma


def _all_rates() -> Floats:
    """Return velocities of a and b and spins of a and b, before and after, (24, 48)."""
    functional = np.zeros((24, NUMBERS))
    order = [(i, spin, after) for after in (False, True) for spin in (False, True) for i in (0, 1)]
    for k, (sphere, spin, after) in enumerate(order):
        functional[3 * k : 3 * k + 3, place_of_rate(sphere, spin=spin, after=after)] = np.eye(3)
    return functional


def _scalars(bodies: tuple[Body, Body]) -> Floats:
    """Return v_n, v_s, v_n', v_s' along the standing directions, (4, 48).

    v_s = V . t + (R_a w_a + R_b w_b) . (t x n), thesis, section 7.1.
    """
    functional = np.zeros((4, NUMBERS))
    for side, after in enumerate((False, True)):
        for i, sign in enumerate((-1.0, 1.0)):
            functional[2 * side, place_of_rate(i, spin=False, after=after)] = sign * NORMAL
            functional[2 * side + 1, place_of_rate(i, spin=False, after=after)] = sign * ALONG
            lever = bodies[i].radius * np.cross(ALONG, NORMAL)
            functional[2 * side + 1, place_of_rate(i, spin=True, after=after)] = lever
    return functional


def _open(bodies: tuple[Body, Body], *, scalars: bool) -> NDArray[np.bool_]:
    """Return which of a shot's own numbers are fitted: how bodies move that are no plate.

    Of scalars the velocities in the plane of n and t, which make up all that can be told.
    """
    velocity = (NORMAL + ALONG) > 0 if scalars else np.ones(3, dtype=np.bool_)
    spin = np.full(3, not scalars)
    fitted = np.zeros(SIZE, dtype=np.bool_)
    fitted[MOTION] = np.concatenate(
        [kind & (not body.is_plate) for kind in (velocity, spin) for body in bodies]
    )
    return fitted


ROUNDS = 12
SETTLED = 0.01
LEAST_SPREAD = 1e-9
"""Of sigmas over their first guess: less is the rounding of a table that fits exactly."""
LEAST_FREEDOM = 0.25
"""Of a channel in a shot: with less it has no scatter of its own, and takes that of all."""
LEAST_SINGULAR = 1e-9


def with_scatter_as_noise(table: ContactTable, theory: Theory | None = None) -> ContactTable:
    """Multiply the sigmas of each channel by a factor, so that a theory fits as noise lets it.

    The factor is that of the median shot, which bad shots do not move: the chi-squared of its
    channel is set to the median of its distribution. Which channel a fit gives way to depends on
    the factors, so they are found in a few rounds.

    Parameters
    ----------
    theory
        Law and effects to start from; None: the hard-sphere operator alone.

    Raises
    ------
    ValueError
        More is fitted than is tabulated, or the table fits exactly.
    """
    whole = np.ones(len(table.channels))
    for _ in range(ROUNDS):
        factors = _factors(table, fit_campaign(table, theory))
        whole *= factors
        if whole.min() < LEAST_SPREAD:
            raise ValueError("the numbers fit the model exactly, so that there is no scatter")
        table = table.scaled(factors @ table.channels)
        if (np.abs(factors - 1) < SETTLED).all():
            break
    return table


def _factors(table: ContactTable, fit: Fit) -> Floats:
    """Return by what the sigmas of each channel are to be multiplied, shape (channels,)."""
    left = fit.shot_residuals - fit.nuisance_count
    if fit.freedom < 1 or not (left > 0).any():
        raise ValueError(
            f"{fit.residuals} numbers leave no scatter about {fit.residuals - fit.freedom} fitted "
            "ones"
        )
    # Fitted parameters take their share of the scatter from every shot alike.
    share = fit.freedom / left.sum()
    squares, freedom = _scatter(table, fit)
    channels = table.channels.astype(np.float64)
    together = _factor(fit.shot_chi2, share * left)
    apart = zip((squares @ channels.T).T, share * (freedom @ channels.T).T, strict=True)
    return np.array([_factor(own, free) or together for own, free in apart])


def _factor(chi2: Floats, freedom: Floats) -> float:
    """Return the factor of the median shot, 0 where no shot has any freedom."""
    told = freedom > LEAST_FREEDOM
    if not told.any():
        return 0.0
    expected = chi_squared.median(freedom[told])
    return float(np.sqrt(np.median(chi2[told] / expected)))


def _scatter(table: ContactTable, fit: Fit) -> tuple[Floats, Floats]:
    """Return squares of whitened residuals and one less the leverage of each, shape (S, L).

    The leverage is that of the shot's own numbers.
    """
    line, _ = compare(table, fit.states, fit.theory)
    shots, length = table.sigma.shape
    slopes = line.slopes.reshape(shots, length, -1) @ line.by_state[:, :, table.open]
    left, singular, _ = np.linalg.svd(slopes, full_matrices=False)
    fitted = singular > LEAST_SINGULAR * singular.max(axis=1, keepdims=True)
    leverage = (left**2 * fitted[:, None, :]).sum(axis=2)
    squares = line.residual.reshape(shots, length) ** 2
    return squares, np.where(table.measured, 1.0 - leverage, 0.0)
