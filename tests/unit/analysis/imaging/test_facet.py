import math

import numpy as np
import pytest
from facets import facet_value
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.polynomial.polynomial import polyder, polyval2d
from scipy.special import ndtr

from analysis.imaging.edge.edges import laplacian_of_gaussian
from analysis.imaging.edge.facet import EdgePoints, edge_points, facet_coefficients
from analysis.imaging.edge.frame import gradient_threshold

STEP = 120.0
values = arrays(np.float64, (3, 3), elements=st.floats(-100, 100))
offset = st.floats(-1.0, 1.0)


@given(nine=values)
def test_the_facet_passes_through_all_nine_values(nine: np.ndarray) -> None:
    r, c = (axis.ravel().astype(np.float64) for axis in np.mgrid[-1:2, -1:2])
    coefficients = np.repeat(facet_coefficients(nine[None]), 9, axis=0)
    value, _, _ = facet_value(coefficients, r, c)
    np.testing.assert_allclose(value, nine.ravel(), atol=1e-10)


@given(polynomial=values, r=offset, c=offset)
def test_between_the_pixels_the_facet_is_the_biquadratic_with_its_slopes(
    polynomial: np.ndarray, r: float, c: float
) -> None:
    rows, columns = np.mgrid[-1:2, -1:2].astype(np.float64)
    coefficients = facet_coefficients(polyval2d(rows, columns, polynomial)[None])
    found = facet_value(coefficients, np.array([r]), np.array([c]))
    expected = [
        polyval2d(r, c, p) for p in (polynomial, polyder(polynomial), polyder(polynomial, axis=1))
    ]
    np.testing.assert_allclose(np.ravel(found), expected, atol=1e-9)


def straight_edge(angle: float, shift: float, blur: float) -> tuple[np.ndarray, np.ndarray]:
    """Return an edge blurred by a Gaussian, and the signed distance of every pixel from it."""
    r, c = np.mgrid[-24:25, -24:25].astype(np.float64)
    distance = math.cos(angle) * r + math.sin(angle) * c - shift
    return 40.0 + STEP * ndtr(distance / blur), distance


def away_from_the_rim(points: EdgePoints) -> EdgePoints:
    inner = (np.abs(points.row - 24) < 14) & (np.abs(points.column - 24) < 14)
    return points.where(inner)


@settings(max_examples=60, deadline=None)
@given(
    angle=st.floats(0.0, 2 * math.pi),
    shift=st.floats(-1.0, 1.0),
    blur=st.floats(0.7, 1.5),
    sigma=st.sampled_from([1.2, 2.0]),
)
def test_a_blurred_edge_is_found_within_a_hundredth_of_a_pixel(
    angle: float, shift: float, blur: float, sigma: float
) -> None:
    frame, _ = straight_edge(angle, shift, blur)
    points = away_from_the_rim(edge_points(laplacian_of_gaussian(frame, sigma), 5.0))
    normal = np.array([math.cos(angle), math.sin(angle)])
    distance = (points.row - 24) * normal[0] + (points.column - 24) * normal[1] - shift
    assert len(points) >= 20
    assert np.abs(distance).max() < 0.01
    assert (points.normal_row * normal[0] + points.normal_column * normal[1]).min() > 0.9999
    # The steepest slope of an edge of this width, blurred once more by the filter.
    steepest = STEP / math.sqrt(2 * math.pi * (blur**2 + sigma**2))
    np.testing.assert_allclose(points.strength, steepest, rtol=0.12)


@pytest.mark.parametrize("samples", [3, 4])
def test_samples_a_pixel_round_the_root_to_their_grid(samples: int) -> None:
    edges = laplacian_of_gaussian(straight_edge(0.4, 0.3, 1.0)[0], 2.0)
    exact, rounded = edge_points(edges, 5.0), edge_points(edges, 5.0, samples)
    for fine, coarse in ((exact.row, rounded.row), (exact.column, rounded.column)):
        steps = coarse * samples
        np.testing.assert_allclose(steps, np.rint(steps), atol=1e-9)
        assert np.abs(coarse - fine).max() <= 0.5 / samples + 1e-9
        assert np.abs(coarse - fine).max() > 0.3 / samples


def test_an_edge_weaker_than_the_threshold_is_noise() -> None:
    edges = laplacian_of_gaussian(straight_edge(0.4, 0.3, 1.0)[0], 2.0)
    # The step's steepest slope is 120 / sqrt(2 pi 5) = 21.4 levels a pixel.
    assert len(away_from_the_rim(edge_points(edges, 18.0))) > 0
    assert len(edge_points(edges, 25.0)) == 0


@pytest.mark.parametrize("sigma", [1.2, 2.0])
def test_a_flat_noisy_frame_has_almost_no_edge_points(sigma: float) -> None:
    rng = np.random.default_rng(4)
    found = 0
    for _ in range(25):
        frame = np.clip(np.rint(80 + 4.0 * rng.standard_normal((192, 240))), 0, 255)
        points = edge_points(laplacian_of_gaussian(frame, sigma), gradient_threshold(4.0, sigma))
        found += len(points)
    # Of more than a million pixels.
    assert found <= 4


def test_chosen_points_keep_all_their_attributes() -> None:
    points = edge_points(laplacian_of_gaussian(straight_edge(0.4, 0.3, 1.0)[0]), 5.0)
    third = points.where(np.array([2]))
    assert len(third) == 1
    assert [getattr(third, name)[0] for name in EdgePoints.__slots__] == [
        getattr(points, name)[2] for name in EdgePoints.__slots__
    ]
