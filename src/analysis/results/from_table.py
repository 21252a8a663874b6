"""Impacts from a table of contacts: states before and after, or their scalars."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import Body, States, surface_velocity
from analysis.model.data.tables import ContactTable
from analysis.results.impacts import V_S, V_S_AFTER, Impacts, measured_impacts

STEP = 0.1
"""Of each number's standard error, for derivatives."""


def table_impacts(table: ContactTable) -> Impacts:
    """Measure the impact of every row; the normal is taken as exact, as the table has it."""
    if table.scalars:
        numbers = np.where(table.measured, table.numbers, np.nan)
        variance = np.where(table.measured, table.sigma, 0.0) ** 2
        return measured_impacts(
            table.shots, numbers, variance[:, :, None] * np.eye(4), table.bodies
        )
    velocities = _scalars(table, table.numbers)
    covariance = _carried(table)
    missing = ~table.measured[:, _spins(table)].all(axis=1)
    velocities[missing, V_S] = velocities[missing, V_S_AFTER] = np.nan
    return measured_impacts(table.shots, velocities, covariance, table.bodies)


def _spins(table: ContactTable) -> NDArray[np.intp]:
    """Return where the spins stand among the 24 numbers; a plate has none to be measured."""
    own = np.arange(6, 9 if table.bodies[1].is_plate else 12)
    return np.concatenate([own, own + 12])


def _scalars(table: ContactTable, numbers: Floats) -> Floats:
    """Return v_n, v_s, v_n', v_s' (thesis, section 7.1), m/s, shape (S, 4)."""
    normal = table.normal
    (before, incident), (after, leaving) = (
        _side(numbers[:, part], normal, table.bodies) for part in (slice(0, 12), slice(12, 24))
    )
    length = np.linalg.norm(incident, axis=1)
    along = incident / np.maximum(length, 1e-12)[:, None]
    return np.stack([before, length, after, (leaving * along).sum(axis=1)], axis=1)


def _side(state: Floats, normal: Floats, bodies: tuple[Body, Body]) -> tuple[Floats, Floats]:
    """Return the relative velocity along the normal (S,) and that of the surfaces (S, 3)."""
    a, b, spin_a, spin_b = (state[:, k : k + 3] for k in (0, 3, 6, 9))
    surface = surface_velocity(States(a, b, spin_a, spin_b), normal, bodies)
    return ((b - a) * normal).sum(axis=1), surface


def _carried(table: ContactTable) -> Floats:
    """Carry the errors of the 24 numbers to the four velocities, shape (S, 4, 4)."""
    sigma = np.where(table.measured, table.sigma, 0.0)
    slopes = np.zeros((len(table.shots), 4, sigma.shape[1]))
    for k in range(sigma.shape[1]):
        step = np.zeros_like(sigma)
        step[:, k] = np.maximum(STEP * sigma[:, k], 1e-9)
        change = _scalars(table, table.numbers + step) - _scalars(table, table.numbers - step)
        slopes[:, :, k] = change / (2 * step[:, k : k + 1]) * sigma[:, k : k + 1]
    return np.asarray(slopes @ slopes.swapaxes(1, 2))
