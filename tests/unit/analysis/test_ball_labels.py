"""The labels of bounces on the picture of a film do not lie on each other."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from analysis.figures.ball_film import LABEL_HEIGHT, LABEL_WIDTH, free_heights


@pytest.mark.parametrize("crowd", [1, 3, 12])
def test_no_label_lies_on_another_however_many_bounces_are_alike(crowd: int) -> None:
    points = np.random.default_rng(crowd).normal([100.0, 50.0], 4.0, (crowd, 2))
    heights = points[:, 1] + free_heights(points)
    assert all(abs(one - other) >= LABEL_HEIGHT for one, other in combinations(heights, 2))


def test_labels_of_points_that_lie_apart_stay_beside_them() -> None:
    apart = np.array([[0.0, 5.0], [1.01 * LABEL_WIDTH, 5.0], [0.0, 5.0 + 1.01 * LABEL_HEIGHT]])
    assert free_heights(apart) == [0.0, 0.0, 0.0]
