"""On the picture of a film labels do not lie on each other, and places are where they are."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from analysis.figures.flights import LABEL_HEIGHT, LABEL_WIDTH, free_heights, mark


@pytest.mark.parametrize("crowd", [1, 3, 12])
def test_no_label_lies_on_another_however_many_bounces_are_alike(crowd: int) -> None:
    points = np.random.default_rng(crowd).normal([100.0, 50.0], 4.0, (crowd, 2))
    heights = points[:, 1] + free_heights(points)
    assert all(abs(one - other) >= LABEL_HEIGHT for one, other in combinations(heights, 2))


def test_labels_of_points_that_lie_apart_stay_beside_them() -> None:
    apart = np.array([[0.0, 5.0], [1.01 * LABEL_WIDTH, 5.0], [0.0, 5.0 + 1.01 * LABEL_HEIGHT]])
    assert free_heights(apart) == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("part", [0.0, 0.3, 0.5, 0.8])
def test_a_place_is_drawn_where_it_is_between_the_pixels(part: float) -> None:
    figure = Figure(figsize=(1.0, 1.0), dpi=60)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0, 60), ylim=(60, 0))
    axes.axis("off")
    # Two alike: those of one look are drawn together.
    mark(axes, (np.array([20 + part, 40 + part]), np.array([30 + part, 30 + part])), 30.0, lw=0)
    canvas.draw()
    dark = 255.0 - np.asarray(canvas.buffer_rgba())[..., 0]
    rows, columns = np.indices(dark.shape) + 0.5
    middle = (dark * rows).sum() / dark.sum(), (dark * columns).sum() / dark.sum()
    assert middle == pytest.approx((30 + part, 30 + part), abs=0.1)
