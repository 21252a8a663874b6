import drawings
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis.imaging.edge.facet import EdgePoints
from analysis.qualification.locating import CELLS, adaptive_hough, centre_votes

ROWS, COLUMNS, RADII = (20.0, 70.0), (30.0, 90.0), (10.0, 30.0)


def rim(row: float, column: float, radius: float, angles: np.ndarray) -> EdgePoints:
    c, s = np.cos(angles), np.sin(angles)
    zero = np.zeros(angles.size, dtype=np.intp)
    at = (row + radius * c, column + radius * s)
    return EdgePoints(*at, -c, -s, np.ones(angles.size), zero, zero)


@settings(max_examples=40, deadline=None)
@given(
    row=st.floats(25, 65), column=st.floats(35, 85), radius=st.floats(12, 28), turn=st.floats(0, 6)
)
def test_an_exact_rim_gives_its_circle_to_a_cell(
    row: float, column: float, radius: float, turn: float
) -> None:
    points = rim(row, column, radius, turn + np.linspace(0, 2 * np.pi, 120, endpoint=False))
    found = adaptive_hough(points, ROWS, COLUMNS, RADII)
    assert found is not None
    assert found == pytest.approx((row, column, radius), abs=0.25)


def test_a_drawn_disc_with_noise_is_found_within_a_third_of_a_pixel() -> None:
    place = (45.3, 60.7, 20.0)
    points = drawings.edges_of(drawings.draw([place]), noise=3.0).points
    found = adaptive_hough(points, ROWS, COLUMNS, RADII)
    assert found is not None
    assert found[:2] == pytest.approx(place[:2], abs=0.33)
    assert found[2] == pytest.approx(place[2], abs=0.5)


def test_a_cell_counts_the_normals_that_cross_it_and_no_others() -> None:
    points = rim(50.0, 60.0, 20.0, np.array([0.3, 1.9, 4.0]))
    ranges = np.array([[45.0, 54.0], [55.5, 64.5]])
    votes = centre_votes(points, ranges)
    assert votes[CELLS // 2, CELLS // 2] == votes.max() == 3
    along = np.linspace(-40, 40, 80_001)
    for point in range(3):
        r = points.row[point] + along * points.normal_row[point]
        c = points.column[point] + along * points.normal_column[point]
        crossed, _, _ = np.histogram2d(r, c, CELLS, [ranges[0], ranges[1]])
        own = points.where(np.array([point]))
        np.testing.assert_array_equal(centre_votes(own, ranges) > 0, crossed > 0)


def test_a_range_without_the_circle_gives_none() -> None:
    points = rim(50.0, 60.0, 20.0, np.linspace(0, 1, 20))
    assert adaptive_hough(points, (0.0, 5.0), (90.0, 95.0), RADII) is None
    assert adaptive_hough(points, ROWS, COLUMNS, (1.0, 9.0)) is None
