import drawings
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from analysis.qualification.grey_discs import fit_grey_discs

PLACES = [(40.3, 60.7, 16.0), (41.1, 58.2, 16.0), (44.6, 61.9, 16.0), (46.0, 55.4, 16.0)]
ROUGH = [(row + 0.6, column - 0.5, 15.4) for row, column, _ in PLACES]


def ball(place: tuple[float, float, float]) -> np.ndarray:
    """Draw a sphere whose light falls off towards the limb and across, on sub-pixels."""
    row, column, radius = place
    fine = (np.arange(96 * 8) + 0.5) / 8 - 0.5
    u = (fine[:, None] - row) / radius
    v = ((np.arange(120 * 8) + 0.5) / 8 - 0.5 - column)[None, :] / radius
    square = u**2 + v**2
    height = np.sqrt(np.clip(1 - square, 0, None))
    grey = np.where(square <= 1, 100 + 40 * height + 15 * u - 10 * v * height, 40.0)
    return grey.reshape(96, 8, 120, 8).mean(axis=(1, 3))


def test_a_shaded_sphere_is_found_to_a_hundredth_of_a_pixel_with_honest_errors() -> None:
    frames = np.stack(
        [
            drawings.grey(gaussian_filter(ball(place), 0.8, mode="nearest"), noise=1.0, seed=k)
            for k, place in enumerate(PLACES)
        ]
    )
    found = fit_grey_discs(frames, ROUGH, shaded=True)
    truth = np.array([place[:2] for place in PLACES])
    assert np.abs(found.centres - truth).max() < 0.02
    pulls = (found.centres - truth) / found.sigma
    assert np.abs(pulls).max() < 3.5
    assert abs(found.radius - 16.0) < 3.5 * found.radius_sigma < 0.1
    assert found.blur_px == pytest.approx(np.hypot(0.8, 12**-0.5), abs=0.03)
    assert found.noise == pytest.approx(np.hypot(1.0, 12**-0.5), rel=0.05)


def test_a_flat_dark_marker_on_a_bright_ground_is_found_likewise() -> None:
    places = [(row, column, 5.0) for row, column, _ in PLACES]
    frames = np.stack(
        [
            drawings.grey(drawings.draw([(45.0, 60.0, 38.0)], markers=[place]), noise=1.0, seed=k)
            for k, place in enumerate(places)
        ]
    )
    found = fit_grey_discs(frames, [(r + 0.3, c - 0.3, 5.3) for r, c, _ in places], shaded=False)
    truth = np.array([place[:2] for place in places])
    assert np.abs(found.centres - truth).max() < 0.03
    assert found.radius == pytest.approx(5.0, abs=0.03)
