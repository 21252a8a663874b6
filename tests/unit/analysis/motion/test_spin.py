import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.motion.drift import Drift
from analysis.motion.spin import fit_spin, three_frame_spin

NO_DRIFT = Drift(0.0, 1.0)
TIMES = np.array([0.0, 1.0, 2.0, 4.0, 5.0, 6.0, 7.0]) * 1e-3
OMEGA = np.array([40.0, -25.0, 60.0])
START = Rotation.from_rotvec([0.7, -2.0, 1.0])
SIGMA = np.array([0.01, 0.015, 0.02])
COVARIANCE = np.tile(np.diag(SIGMA**2), (7, 1, 1))


def turned(omega: np.ndarray = OMEGA, times: np.ndarray = TIMES) -> np.ndarray:
    return np.array([(Rotation.from_rotvec(omega * t) * START).as_matrix() for t in times])


def shaken(rng: np.random.Generator, rotations: np.ndarray, errors: np.ndarray) -> np.ndarray:
    shakes = Rotation.from_rotvec(errors * rng.standard_normal((len(rotations), 3)))
    return shakes.as_matrix() @ rotations


@pytest.mark.parametrize("omega", [OMEGA, np.array([0.0, 0.0, 0.0]), np.array([300.0, 0.0, 50.0])])
def test_exact_orientations_give_their_spin(omega: np.ndarray) -> None:
    spin = fit_spin(TIMES, turned(omega), COVARIANCE, NO_DRIFT)
    np.testing.assert_allclose(spin.velocity, omega, atol=1e-8)
    assert spin.chi2_per_dof == pytest.approx(0.0, abs=1e-9)


def test_the_covariance_is_the_scatter_under_white_noise() -> None:
    rng, true = np.random.default_rng(3), turned()
    spins = [fit_spin(TIMES, shaken(rng, true, SIGMA), COVARIANCE, NO_DRIFT) for _ in range(250)]
    scatter = np.std([spin.velocity for spin in spins], axis=0)
    stated = np.sqrt(np.diag(fit_spin(TIMES, true, COVARIANCE, NO_DRIFT).covariance))
    np.testing.assert_allclose(stated, scatter, rtol=0.15)
    assert np.mean([spin.chi2_per_dof for spin in spins]) == pytest.approx(1.0, abs=0.1)
    mean = np.mean([spin.velocity for spin in spins], axis=0)
    assert (np.abs(mean - OMEGA) < 4 * scatter / math.sqrt(250)).all()


FAST = np.array([500.0, -300.0, 600.0])
"""rad/s: nearly six radians in the seven milliseconds of the film."""


def test_a_fast_spin_scatters_as_little_as_its_orientations_allow() -> None:
    rng, true, sigma = np.random.default_rng(3), turned(FAST), np.full(3, 0.01)
    covariance = np.tile(np.diag(sigma**2), (7, 1, 1))
    found = [fit_spin(TIMES, shaken(rng, true, sigma), covariance, NO_DRIFT) for _ in range(400)]
    along = FAST / np.linalg.norm(FAST)
    off = np.array([one.velocity for one in found]) - FAST
    # Across the axis an orientation is off by what is constant, the spin's direction, and by what
    # turns with the sphere, its start: as complex numbers 1 and exp(i w t).
    length = np.linalg.norm(FAST)
    circle = np.stack([np.ones(7), np.exp(1j * length * TIMES)], axis=1)
    bound = length * 0.01 * np.sqrt(np.linalg.inv(circle.conj().T @ circle)[0, 0].real)
    across = np.sqrt((np.square(off).sum(axis=1) - (off @ along) ** 2).mean() / 2.0)
    assert across == pytest.approx(bound, rel=0.1)
    stated = np.mean([np.trace(one.covariance) - along @ one.covariance @ along for one in found])
    assert np.sqrt(stated / 2.0) == pytest.approx(across, rel=0.1)


def test_a_slow_error_is_in_the_covariance() -> None:
    drift = Drift(0.02, 5e-3)
    rng, true = np.random.default_rng(4), turned()
    root = np.linalg.cholesky(drift.covariance(TIMES))
    found = []
    for _ in range(250):
        slow = Rotation.from_rotvec(root @ rng.standard_normal((7, 3))).as_matrix()
        found.append(fit_spin(TIMES, slow @ shaken(rng, true, SIGMA), COVARIANCE, drift).velocity)
    stated = np.sqrt(np.diag(fit_spin(TIMES, true, COVARIANCE, drift).covariance))
    np.testing.assert_allclose(stated, np.std(found, axis=0), rtol=0.2)


def test_a_slow_error_far_larger_than_stated_is_seen_in_what_neighbouring_frames_share() -> None:
    stated, true = Drift(0.002, 5e-3), Drift(0.02, 5e-3)
    times = np.arange(40) * 1e-3
    rng, rotations = np.random.default_rng(5), turned(times=times)
    covariances = np.tile(np.diag(np.full(3, 0.003) ** 2), (40, 1, 1))
    root = np.linalg.cholesky(true.covariance(times))
    pulls = []
    for size in [1.0, 0.1] * 40:
        slow = Rotation.from_rotvec(size * root @ rng.standard_normal((40, 3))).as_matrix()
        seen = slow @ shaken(rng, rotations, np.full(3, 0.003))
        spin = fit_spin(times, seen, covariances, stated)
        pulls.append((spin.velocity - OMEGA) / np.sqrt(np.diag(spin.covariance)))
    wandering, as_stated = np.sqrt(np.square(pulls).reshape(40, 2, 3).mean(axis=(0, 2)))
    # Ten times the error in every second flight, which would be off by ten of its errors.
    assert 0.7 < wandering < 1.6
    assert 0.8 < as_stated < 1.2


def enlarged(rng: np.random.Generator, frames: int, *, wrong: float = 0.0) -> float:
    """By how much the variance that a stated slow error adds exceeds what it adds by itself."""
    stated, fresh, times = Drift(0.0005, 5e-3), np.full(3, 0.003), np.arange(frames) * 1e-3
    rotations = turned(times=times)
    covariances = np.tile(np.diag(fresh**2), (frames, 1, 1))
    root = np.linalg.cholesky(stated.covariance(times))
    slow = Rotation.from_rotvec(root @ rng.standard_normal((frames, 3))).as_matrix()
    seen = slow @ shaken(rng, rotations, fresh)
    for k in (frames // 3, frames // 3 + 1):
        seen[k] = Rotation.from_rotvec([wrong, 0.0, 0.0]).as_matrix() @ seen[k]
    added = [
        np.trace(fit_spin(times, own, covariances, stated).covariance)
        - np.trace(fit_spin(times, own, covariances, NO_DRIFT).covariance)
        for own in (seen, rotations)
    ]
    return float(added[0] / added[1])


@pytest.mark.parametrize("frames", [8, 20, 40])
def test_chance_enlarges_no_slow_error(frames: int) -> None:
    rng = np.random.default_rng(8)
    grown = [enlarged(rng, frames) for _ in range(150)]
    assert np.mean(np.array(grown) > 1.5) < 0.02


def test_two_orientations_in_a_wrong_turn_are_no_slow_error() -> None:
    rng = np.random.default_rng(9)
    grown = [enlarged(rng, 40, wrong=0.3) for _ in range(20)]
    assert np.median(grown) < 1.5


def test_one_wrong_orientation_does_not_turn_the_spin() -> None:
    rng = np.random.default_rng(6)
    rotations = shaken(rng, turned(), SIGMA)
    rotations[-1] = Rotation.from_rotvec([0.0, 0.5, 0.0]).as_matrix() @ rotations[-1]
    spin = fit_spin(TIMES, rotations, COVARIANCE, NO_DRIFT)
    # Without Huber's weights the outlier would pull by some 0.5 rad * 0.13 / ms = 40 rad/s.
    assert np.linalg.norm(spin.velocity - OMEGA) < 12.0
    assert spin.chi2_per_dof > 3.0


def test_two_orientations_give_a_spin_without_freedom() -> None:
    spin = fit_spin(TIMES[:2], turned()[:2], COVARIANCE[:2], NO_DRIFT)
    np.testing.assert_allclose(spin.velocity, OMEGA, atol=1e-8)
    assert math.isnan(spin.chi2_per_dof)
    # Exact but for the 0.08 rad that the sphere turns between them.
    expected = math.sqrt(2) * SIGMA / 1e-3
    np.testing.assert_allclose(np.sqrt(np.diag(spin.covariance)), expected, rtol=2e-3)


@pytest.mark.parametrize(("nearest", "expected"), [(0, 7 / 3), (-1, 49 / 3)])
def test_equations_5_32_and_5_33_worked_by_hand(nearest: int, expected: float) -> None:
    # Turns of 0.014 rad in 2 ms and 0.014 rad in 1 ms: mean rates 7 and 14 rad/s at 1 and 2.5 ms.
    # A straight line through them, 7 + 14/3 (t - 1), is 7/3 at 0 and 49/3 at 3 ms.
    times = np.array([0.0, 2e-3, 3e-3])
    angles = np.array([0.0, 0.014, 0.028])
    rotations = Rotation.from_rotvec(angles[:, None] * [0.0, 0.0, 1.0]).as_matrix()
    spin = three_frame_spin(times, rotations, COVARIANCE[:3], NO_DRIFT, nearest)
    np.testing.assert_allclose(spin.velocity, (0.0, 0.0, expected), atol=1e-9)


@pytest.mark.parametrize("nearest", [0, -1])
def test_the_covariance_of_three_frames_is_their_scatter(nearest: int) -> None:
    times, rng = TIMES[[0, 2, 3]], np.random.default_rng(7)
    true, covariances = turned(times=times), COVARIANCE[:3]
    spins = [
        three_frame_spin(times, shaken(rng, true, SIGMA), covariances, NO_DRIFT, nearest).velocity
        for _ in range(400)
    ]
    stated = three_frame_spin(times, true, covariances, NO_DRIFT, nearest)
    np.testing.assert_allclose(stated.velocity, OMEGA, atol=1e-8)
    np.testing.assert_allclose(
        np.sqrt(np.diag(stated.covariance)), np.std(spins, axis=0), rtol=0.12
    )
