import numpy as np
import pytest
from drawings import draw, grey
from scipy import ndimage

from analysis.imaging.edge.frame import EdgeSettings, find_edges, gradient_threshold, noise_sd
from simulators.world import Launch, WorldDescription, render_shot
from simulators.world.optics import Optics


def frames_with_noise(noise: float) -> np.ndarray:
    description = WorldDescription(optics=Optics(noise_grey=noise))
    return render_shot(description, Launch(40.0, 40.0, 0.006), 3, frames=8).frames


@pytest.mark.parametrize("noise", [1.0, 2.0, 4.0])
def test_the_noise_is_known_within_five_per_cent_with_spheres_in_the_frame(noise: float) -> None:
    # Rounding to 8 bit adds a twelfth of a squared level.
    expected = np.sqrt(noise**2 + 1 / 12)
    assert noise_sd(frames_with_noise(noise)) == pytest.approx(expected, rel=0.05)


def test_frames_without_noise_have_that_of_rounding() -> None:
    assert noise_sd(np.full((3, 20, 20), 50, dtype=np.uint8)) == pytest.approx(12**-0.5)


@pytest.mark.parametrize("sigma", [1.0, 1.2, 2.0])
def test_the_threshold_stands_five_standard_errors_above_smoothed_noise(sigma: float) -> None:
    noise = 3.0 * np.random.default_rng(5).standard_normal((400, 400))
    component = ndimage.gaussian_filter(noise, sigma, order=(1, 0)).std()
    assert gradient_threshold(3.0, sigma) == pytest.approx(5.3 * component, rel=0.03)


def test_each_closed_curve_of_a_frame_has_a_label_of_its_own() -> None:
    frame = grey(draw([(48.0, 60.0, 30.0)], markers=[(45.0, 50.0, 5.0), (50.0, 72.0, 5.0)]))
    edges = find_edges(frame, EdgeSettings(1.2), 4.0)
    points, labels = edges.points, edges.labels
    places = [(48.0, 60.0, 30.0), (45.0, 50.0, 5.0), (50.0, 72.0, 5.0)]
    names = set()
    for row, column, radius in places:
        rho = np.hypot(points.row - row, points.column - column)
        own = np.unique(labels[np.abs(rho - radius) < 0.5])
        assert own.size == 1
        names.add(int(own[0]))
    assert len(names) == len(places)
    assert edges.shape == (96, 120)
