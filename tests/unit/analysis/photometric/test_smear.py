import numpy as np
import pytest

from analysis.motion.rotation import rotation_matrix
from analysis.photometric.render.pose import fit_pose
from analysis.photometric.render.smear import motion_through, round_variance
from tests.unit.analysis.photometric.drawn import (
    sight_of,
    sphere_image,
    spread_markers,
    stance_at,
    with_noise,
)

PLACE, RADIUS, NOISE = (31.3, 32.2), 20.0, 2.0
MARKERS = spread_markers(16, seed=2)
LIMITS = np.array([40.0, 10.0, 6.0, 6.0])
INSTANTS = 15
ONE = np.eye(3)[None]


def exposed(way: tuple[float, float]) -> np.ndarray:
    """Draw the mean of the images along a way in pixels, about PLACE in its middle."""
    shares = (np.arange(INSTANTS) + 0.5) / INSTANTS - 0.5
    places = [(PLACE[0] + s * way[0], PLACE[1] + s * way[1]) for s in shares]
    return np.mean([sphere_image(place=p, radius=RADIUS, markers=MARKERS) for p in places], axis=0)


def fitted(way: tuple[float, float], told: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Fit twelve noisy images; return the centres' errors over stated ones, and chi-squared."""
    clear, pulls, chi2 = exposed(way), [], []
    for seed in range(12):
        sight = sight_of(with_noise(clear, NOISE, seed), MARKERS, radius=RADIUS, noise=NOISE)
        motion = np.array([told[0] / RADIUS, told[1] / RADIUS, 0.0, 0.0, 0.0, 0.0])
        stance, covariance = stance_at(*PLACE, RADIUS), np.zeros((6, 6))
        quality = fit_pose(sight._replace(motion=motion), stance, LIMITS, covariance)
        off = stance.centre[:2] * RADIUS - np.array(PLACE)
        pulls.append(off / (RADIUS * np.sqrt(np.diag(covariance)[:2])))
        chi2.append(quality[0] / quality[1])
    return np.array(pulls), np.array(chi2)


@pytest.mark.parametrize("way", [(0.0, 3.7), (2.6, 2.6), (-3.0, 1.0)])
def test_a_smear_that_is_known_leaves_the_noise_alone(way: tuple[float, float]) -> None:
    pulls, chi2 = fitted(way, told=way)
    # With no smear the biweight leaves 0.88 of the variance.
    assert 0.8 < chi2.mean() < 0.96
    assert 0.6 < np.sqrt((pulls**2).mean()) < 1.4


def test_a_smear_that_is_not_known_does_not_fit() -> None:
    _, chi2 = fitted((0.0, 3.7), told=(0.0, 0.0))
    assert chi2.mean() > 1.3


@pytest.mark.parametrize("frame", range(8))
def test_no_frame_takes_its_motion_from_across_a_kink(frame: int) -> None:
    times = np.array([0.0, 1.0, 2.0, 3.0, 5.0, 6.0, 7.0, 8.0]) * 1e-3
    velocities, spins = np.array([[1.0, 2.0, 0.0], [-3.0, 0.5, 1.0]]), np.array([[50.0], [-90.0]])
    kink, axis = 4.2e-3, np.array([0.6, 0.0, 0.8])
    side = (times > kink).astype(int)
    centres = velocities[side] * (times - kink)[:, None]
    rotations = rotation_matrix(spins[side] * (times - kink)[:, None] * axis)
    motion = np.zeros((8, 6))
    motion_through(times, centres, rotations, motion)
    np.testing.assert_allclose(motion[frame, :3], velocities[side[frame]], atol=1e-9)
    np.testing.assert_allclose(motion[frame, 3:], spins[side[frame]] * axis, atol=1e-6)


def test_one_frame_alone_tells_no_motion() -> None:
    motion = np.zeros((1, 6))
    motion_through(np.zeros(1), np.zeros((1, 3)), ONE.copy(), motion)
    assert not motion.any()


def test_the_round_part_of_a_smear_is_half_of_its_variance() -> None:
    optics = sight_of(np.zeros((64, 64), np.uint8), MARKERS, radius=RADIUS, noise=NOISE).optics
    along = np.array([[0.0, 3.0 / RADIUS, 0.0, 0.0, 0.0, 0.0]])
    offsets = np.linspace(-1.5, 1.5, 200_001)
    assert round_variance(optics, along)[0] == pytest.approx(offsets.var() / 2, rel=1e-4)
