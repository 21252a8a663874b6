"""Each shot's equations beside LAPACK's."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.model.loops.blocks import information, solved, whitened, whitenings


def equations(shots: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return normal equations in units that differ by ten orders of magnitude."""
    rng = np.random.default_rng(2)
    rows = rng.normal(size=(shots, 60, 24)) * 10 ** np.linspace(-5, 5, 24)
    return np.swapaxes(rows, 1, 2) @ rows, np.swapaxes(rows, 1, 2) @ rng.normal(
        size=(shots, 60, count)
    )


def solution(matrices: np.ndarray, right: np.ndarray, found: np.ndarray) -> None:
    """Hold a solution against LAPACK's of the equations in units of their own."""
    scale = np.sqrt(np.diagonal(matrices, axis1=1, axis2=2))
    scaled = matrices / scale[:, :, None] / scale[:, None, :]
    expected = np.linalg.solve(scaled, right / scale[..., None])
    np.testing.assert_allclose(found * scale[..., None], expected, rtol=1e-7, atol=1e-8)


@pytest.mark.parametrize("count", [0, 1, 3, 57])
def test_equations_are_solved(count: int) -> None:
    matrices, right = equations(4, count)
    found = solved(matrices, right, np.zeros(4))
    solution(matrices, right, found)


def test_columns_are_taken_to_units_of_independent_errors() -> None:
    variances, columns = equations(4, 3)
    found = whitened(variances, columns)
    expected = np.linalg.solve(np.linalg.cholesky(variances), columns)
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6)
    squares = np.swapaxes(found, 1, 2) @ found
    weighed = np.swapaxes(columns, 1, 2) @ np.linalg.solve(variances, columns)
    np.testing.assert_allclose(squares, weighed, rtol=1e-6)


def test_damping_adds_its_share_of_the_diagonal() -> None:
    matrices, right = equations(3, 2)
    damping = np.array([0.0, 0.1, 10.0])
    index, damped = np.arange(24), matrices.copy()
    damped[:, index, index] *= 1 + damping[:, None]
    found = solved(matrices, right, damping)
    solution(damped, right, found)


def test_numbers_without_information_stay_put() -> None:
    matrices, right = equations(2, 3)
    none = np.array([4, 17])
    matrices[:, none], matrices[:, :, none], right[:, none] = 0.0, 0.0, 0.0
    rest = np.setdiff1d(np.arange(24), none)
    found = solved(matrices, right, np.zeros(2))
    assert not found[:, none].any()
    solution(matrices[:, rest][:, :, rest], right[:, rest], found[:, rest])


def test_two_numbers_that_cannot_be_told_apart_share_what_both_can_do() -> None:
    matrices, right = np.zeros((1, 24, 24)), np.zeros((1, 24, 1))
    matrices[0, :2, :2], right[0, :2] = 1.0, 2.0
    found = solved(matrices, right, np.zeros(1))[0, :, 0]
    np.testing.assert_allclose(found[:2], 1.0, rtol=1e-5)


def test_information_is_the_squares_seen_through_what_numbers_move() -> None:
    rng = np.random.default_rng(6)
    moved, rows = rng.normal(size=(3, 48, 24)), rng.normal(size=(3, 4, 30, 12))
    moved[rng.random(moved.shape) < 0.7], rows[:, :, :15, 6:] = 0.0, 0.0
    slopes = (rows @ moved.reshape(3, 4, 12, 24)).reshape(3, 120, 24)
    found = information(moved, np.swapaxes(rows, 2, 3) @ rows)
    np.testing.assert_allclose(found, np.swapaxes(slopes, 1, 2) @ slopes, rtol=1e-10, atol=1e-10)


def test_columns_are_taken_to_unit_columns_across_each_other() -> None:
    rng = np.random.default_rng(8)
    columns = rng.normal(size=(3, 4, 40, 12)) * 10 ** np.linspace(-4, 4, 12)
    columns[1, 2, :, 5] = 0.0
    columns[2, 0, :, 9] = 3 * columns[2, 0, :, 1] - columns[2, 0, :, 2]
    white = columns @ whitenings(np.swapaxes(columns, 2, 3) @ columns, 1e-12)
    found = np.swapaxes(white, 2, 3) @ white
    expected = np.tile(np.eye(12), (3, 4, 1, 1))
    expected[1, 2, 5, 5] = expected[2, 0, 9, 9] = 0.0
    np.testing.assert_allclose(found, expected, atol=1e-10)
    left = columns - white @ (np.swapaxes(white, 2, 3) @ columns)
    np.testing.assert_allclose(left, 0.0, atol=1e-9 * columns.max())
