"""Roots of many pixels at once against the facet through the nine values about each."""

from __future__ import annotations

import numpy as np
from facets import facet_value

from analysis.imaging.edge.edges import laplacian_of_gaussian
from analysis.imaging.edge.facet import (
    facet_coefficients,
    neighbourhoods,
    zero_crossing_pixels,
)
from analysis.imaging.edge.roots import BAND, LEAST_SLOPE, roots_along


def test_every_root_is_a_zero_of_its_facet_on_the_line_along_the_gradient() -> None:
    y, x = np.mgrid[:70, :80]
    rng = np.random.default_rng(1)
    frame = 100 / (1 + np.exp(np.hypot(y - 34.3, x - 40.8) - 22.0)) + rng.normal(size=y.shape)
    edges = laplacian_of_gaussian(frame, 1.2)
    rows, columns = np.nonzero(zero_crossing_pixels(edges, 4.0))
    pixels, points = np.stack([rows, columns], axis=1), np.empty((len(rows), 5))
    found = roots_along((edges.log, edges.gradient_row, edges.gradient_column), pixels, points)
    assert len(rows) > BAND
    assert len(rows) % BAND
    assert found.mean() > 0.95
    slope = np.hypot(edges.gradient_row, edges.gradient_column).astype(np.float64)
    least = LEAST_SLOPE * slope[rows, columns]
    around = neighbourhoods(edges.log, rows, columns)
    over = np.maximum(neighbourhoods(slope, rows, columns), least[:, None, None])
    d_r, d_c, u_r, u_c, strength = points[found].T
    value, _, _ = facet_value(facet_coefficients(around / over)[found], d_r, d_c)
    np.testing.assert_allclose(value, 0.0, atol=1e-6)
    np.testing.assert_allclose(d_r * u_c, d_c * u_r, atol=1e-12)
    np.testing.assert_allclose(strength, slope[rows, columns][found], rtol=1e-6)
