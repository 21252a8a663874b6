import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import correlate1d

from analysis.imaging.edge.edges import gaussian_kernels, laplacian_of_gaussian
from analysis.imaging.edge.frame import EdgeSettings, find_edges

INNER = slice(20, -20)
slope = st.floats(-2.0, 2.0)
bend = st.floats(-0.05, 0.05)


def test_a_width_of_two_takes_the_seventeen_taps_of_the_thesis() -> None:
    for kernel in gaussian_kernels(2.0):
        assert kernel.shape == (17,)


@pytest.mark.parametrize("sigma", [0.8, 1.2, 2.0, 3.0])
def test_the_kernels_have_the_moments_of_a_gaussian_and_its_derivatives(sigma: float) -> None:
    smooth, first, second = gaussian_kernels(sigma)
    x = np.arange(len(smooth)) - len(smooth) // 2
    moments = [[float((x**power * k).sum()) for power in range(3)] for k in (smooth, first, second)]
    # What four standard deviations on each side cut off is a few thousandths of the variance.
    np.testing.assert_allclose(moments[0], [1.0, 0.0, sigma**2], rtol=6e-3, atol=1e-12)
    np.testing.assert_allclose(moments[1], [0.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(moments[2], [0.0, 0.0, 2.0], atol=1e-12)


@pytest.mark.parametrize("level", [0, 7, 255])
def test_a_flat_frame_gives_zero(level: int) -> None:
    edges = laplacian_of_gaussian(np.full((40, 50), level, dtype=np.uint8))
    for image in (edges.log, edges.gradient_row, edges.gradient_column):
        # 255 levels in single precision.
        assert np.abs(image).max() < 1e-4


@settings(max_examples=30, deadline=None)
@given(a=bend, b=bend, ab=bend, by_row=slope, by_column=slope)
def test_a_quadratic_surface_gives_its_laplacian_and_its_gradient(
    a: float, b: float, ab: float, by_row: float, by_column: float
) -> None:
    r, c = np.mgrid[-32:33, -40:41].astype(np.float64)
    frame = a * r**2 + b * c**2 + ab * r * c + by_row * r + by_column * c + 100.0
    edges = laplacian_of_gaussian(frame, 2.0)
    inner = (INNER, INNER)
    np.testing.assert_allclose(edges.log[inner], 2 * a + 2 * b, atol=1e-3)
    along_row, along_column = 2 * a * r + ab * c + by_row, 2 * b * c + ab * r + by_column
    np.testing.assert_allclose(edges.gradient_row[inner], along_row[inner], atol=1e-3)
    np.testing.assert_allclose(edges.gradient_column[inner], along_column[inner], atol=1e-3)


def test_the_dark_side_of_an_edge_is_positive_and_the_gradient_points_to_the_bright_side() -> None:
    frame = np.zeros((40, 60), dtype=np.uint8)
    frame[:, 30:] = 200
    edges = laplacian_of_gaussian(frame)
    assert (edges.log[:, 28] > 0).all()
    assert (edges.log[:, 31] < 0).all()
    assert (edges.gradient_column[:, 29] > 10).all()
    assert np.abs(edges.gradient_row).max() < 1e-3


def test_a_transposed_frame_gives_the_transposed_edges() -> None:
    frame = np.random.default_rng(1).integers(0, 256, (40, 56), dtype=np.uint8)
    one, other = laplacian_of_gaussian(frame, 1.2), laplacian_of_gaussian(frame.T, 1.2)
    np.testing.assert_allclose(one.log, other.log.T, atol=1e-3)
    np.testing.assert_allclose(one.gradient_row, other.gradient_column.T, atol=1e-3)


@pytest.mark.parametrize("sigma", [0.5, 1.2, 2.0, 4.0, 8.0])
def test_every_width_gives_what_a_plain_correlation_gives_across_the_strips(sigma: float) -> None:
    frame = np.random.default_rng(3).integers(0, 256, (90, 170), dtype=np.uint8)
    smooth, first, second = gaussian_kernels(sigma)

    def filtered(down: np.ndarray, across: np.ndarray) -> np.ndarray:
        once = correlate1d(frame.astype(float), down, axis=0, mode="nearest")
        return np.asarray(correlate1d(once, across, axis=1, mode="nearest"))

    edges = laplacian_of_gaussian(frame, sigma)
    laplacian = filtered(second, smooth) + filtered(smooth, second)
    np.testing.assert_allclose(edges.log, laplacian, atol=2e-3)
    np.testing.assert_allclose(edges.gradient_row, filtered(first, smooth), atol=1e-3)
    np.testing.assert_allclose(edges.gradient_column, filtered(smooth, first), atol=1e-3)


@pytest.mark.parametrize("sigma", [1.2, 2.0, 8.0])
def test_windows_of_every_width_find_the_edge_of_a_half_bright_frame(sigma: float) -> None:
    frame = np.full((120, 200), 20, dtype=np.uint8)
    frame[:, 100:] = 180
    found = find_edges(frame, EdgeSettings(sigma), 1.0).points
    assert len(found) > 60
    np.testing.assert_allclose(found.column, 99.5, atol=0.1)


def test_a_filter_too_wide_for_a_strip_is_refused_with_the_limit() -> None:
    with pytest.raises(ValueError, match=r"filter of 9\.5 pixels; at most 8"):
        laplacian_of_gaussian(np.zeros((20, 20)), 9.5)
