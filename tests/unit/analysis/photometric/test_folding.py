"""Equations put among others and taken out of them, against whole matrices."""

from __future__ import annotations

import numpy as np

from analysis.photometric.learn.shared import eliminate, fold
from analysis.photometric.render.sight import Equations


def positive(size: int, rng: np.random.Generator) -> np.ndarray:
    root = rng.normal(size=(size, size))
    return root @ root.T + np.eye(size)


def test_folding_is_the_product_with_the_derivatives() -> None:
    rng = np.random.default_rng(1)
    normal, right = positive(6, rng), rng.normal(size=6)
    bent, at, others = np.array([0, 1, 4]), np.array([-1, -1, 3, 5, 6, 2]), np.array([0, 1, 7])
    change = rng.normal(size=(3, 3))
    whole = Equations(np.ones((8, 8)), np.ones(8))
    fold(Equations(np.tril(normal), right), (at, bent), (change, others), whole)
    derivatives = np.zeros((6, 8))
    derivatives[np.ix_(bent, others)] = change
    derivatives[[2, 3, 4, 5], at[2:]] = 1.0
    np.testing.assert_allclose(whole.normal, 1.0 + derivatives.T @ normal @ derivatives)
    np.testing.assert_allclose(whole.right, 1.0 + derivatives.T @ right)


def test_what_is_left_after_eliminating_is_solved_as_the_whole_is() -> None:
    rng = np.random.default_rng(2)
    normal, right = positive(9, rng), rng.normal(size=9)
    left = Equations(np.zeros((5, 5)), np.zeros(5))
    eliminate(Equations(normal, right), 4, left)
    np.testing.assert_allclose(
        np.linalg.solve(left.normal, left.right), np.linalg.solve(normal, right)[4:]
    )
