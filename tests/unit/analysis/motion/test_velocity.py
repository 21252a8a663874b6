import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import OdeSolution, solve_ivp

from analysis.motion.drift import Drift
from analysis.motion.velocity import Drag, FlightPath, fit_flight, three_frame_flight

G = 9.80665
DOWN = np.array([1.0, 0.0, 0.0])
NO_DRIFT = Drift(0.0, 1.0)
TIMES = np.array([0.0, 1.0, 2.0, 3.0, 5.0, 6.0, 7.0, 9.0]) * 1e-3
POSITION, VELOCITY = np.array([0.01, -0.03, 0.002]), np.array([-0.2, 2.1, 0.05])
DRAG_PER_M = 0.05
SIGMAS = np.tile([2e-5, 3e-5, 5e-5], (8, 1))


def flown(times_s: np.ndarray, reference_s: float) -> np.ndarray:
    tau = (times_s - reference_s)[:, None]
    return POSITION + VELOCITY * tau + 0.5 * G * DOWN * tau**2


def slowed_by_drag(
    drag_per_m: float = DRAG_PER_M, velocity: np.ndarray = VELOCITY, lasts_s: float = 0.01
) -> OdeSolution:
    def slowed(_: float, state: np.ndarray) -> np.ndarray:
        velocity = state[3:]
        drag = drag_per_m * np.linalg.norm(velocity) * velocity
        return np.concatenate([velocity, G * DOWN - drag])

    start = np.concatenate([POSITION, velocity])
    flight: OdeSolution = solve_ivp(
        slowed, (0.0, lasts_s), start, dense_output=True, rtol=1e-12, atol=1e-12
    ).sol
    return flight


def fit(
    positions: np.ndarray, sigmas: np.ndarray = SIGMAS, reference_s: float = 4e-3
) -> FlightPath:
    return fit_flight(TIMES, positions, sigmas, NO_DRIFT, gravity=G, reference_s=reference_s)


@pytest.mark.parametrize("reference_s", [0.0, 4e-3, 12e-3])
def test_an_exact_parabola_gives_its_position_and_velocity(reference_s: float) -> None:
    path = fit(flown(TIMES, reference_s), reference_s=reference_s)
    np.testing.assert_allclose(path.position, POSITION, atol=1e-12)
    np.testing.assert_allclose(path.velocity, VELOCITY, atol=1e-10)
    np.testing.assert_array_equal(path.acceleration, G * DOWN)
    assert path.chi2_per_dof == pytest.approx(0.0, abs=1e-9)


def test_the_covariance_is_the_scatter_under_white_noise() -> None:
    rng, true = np.random.default_rng(1), flown(TIMES, 4e-3)
    states, stated, chi2 = [], [], []
    for _ in range(600):
        path = fit(true + SIGMAS * rng.standard_normal(true.shape))
        states.append(np.concatenate([path.position, path.velocity]))
        chi2.append(path.chi2_per_dof)
    stated = fit(true).covariance
    scatter = np.cov(np.array(states).T)
    np.testing.assert_allclose(np.sqrt(np.diag(stated)), np.sqrt(np.diag(scatter)), rtol=0.1)
    scale = np.sqrt(np.outer(np.diag(scatter), np.diag(scatter)))
    np.testing.assert_allclose(stated / scale, scatter / scale, atol=0.15)
    assert np.mean(chi2) == pytest.approx(1.0, abs=0.05)


def test_the_error_of_the_velocity_is_that_of_a_straight_line() -> None:
    path = fit(flown(TIMES, 4e-3))
    spread = ((TIMES - TIMES.mean()) ** 2).sum()
    expected = SIGMAS[0] / math.sqrt(spread)
    np.testing.assert_allclose(np.sqrt(np.diag(path.covariance))[3:], expected)


def test_residuals_beyond_their_errors_enlarge_the_covariance_of_their_coordinate_alone() -> None:
    rng, true = np.random.default_rng(2), flown(TIMES, 4e-3)
    noisy = true + SIGMAS * rng.standard_normal(true.shape) * np.array([0.1, 5.0, 0.1])
    plain, enlarged = fit(true).covariance, fit(noisy).covariance
    ratio = np.diag(enlarged) / np.diag(plain)
    np.testing.assert_allclose(ratio[[0, 2, 3, 5]], 1.0)
    assert ratio[1] == pytest.approx(ratio[4])
    assert 8.0 < ratio[1] < 70.0


def test_a_slow_error_is_followed_and_not_averaged_away() -> None:
    drift = Drift(3e-5, 4e-3)
    sigmas = np.full((8, 3), 1e-5)
    rng, true = np.random.default_rng(5), flown(TIMES, 4e-3)
    root = np.linalg.cholesky(drift.covariance(TIMES))
    velocities = []
    for _ in range(600):
        noise = root @ rng.standard_normal(true.shape) + sigmas * rng.standard_normal(true.shape)
        path = fit_flight(TIMES, true + noise, sigmas, drift, gravity=G, reference_s=4e-3)
        velocities.append(path.velocity)
    exact = fit_flight(TIMES, true, sigmas, drift, gravity=G, reference_s=4e-3)
    stated = np.sqrt(np.diag(exact.covariance))[3:]
    np.testing.assert_allclose(stated, np.std(velocities, axis=0), rtol=0.1)
    assert (stated > 2 * np.sqrt(np.diag(fit(true, sigmas).covariance))[3:]).all()


@pytest.mark.parametrize("reference_s", [0.0, 9.5e-3])
def test_a_fit_tells_how_far_drag_that_it_leaves_out_moves_it(reference_s: float) -> None:
    flight = slowed_by_drag()
    path = fit_flight(
        TIMES,
        flight(TIMES).T[:, :3],
        SIGMAS,
        NO_DRIFT,
        gravity=G,
        reference_s=reference_s,
        drag=Drag(sigma_per_m=DRAG_PER_M),
    )
    off = np.concatenate([path.position, path.velocity]) - flight(reference_s)
    # 0.22 m/s^2 over some 4 ms.
    assert abs(off[4]) == pytest.approx(9e-4, rel=0.3)
    np.testing.assert_allclose(path.drag_shift[[1, 4]], off[[1, 4]], rtol=0.05)


@pytest.mark.parametrize("reference_s", [0.0, 9.5e-3])
def test_stated_drag_is_taken_out_of_the_flight(reference_s: float) -> None:
    flight = slowed_by_drag()

    def fitted(drag: Drag) -> FlightPath:
        seen = flight(TIMES).T[:, :3]
        return fit_flight(
            TIMES, seen, SIGMAS, NO_DRIFT, gravity=G, reference_s=reference_s, drag=drag
        )

    def off(path: FlightPath) -> np.ndarray:
        return np.abs(np.concatenate([path.position, path.velocity]) - flight(reference_s))

    known = off(fitted(Drag(DRAG_PER_M, 0.1 * DRAG_PER_M)))
    assert (known[[1, 4]] < 0.03 * off(fitted(Drag()))[[1, 4]]).all()
    shift = fitted(Drag(DRAG_PER_M, 0.1 * DRAG_PER_M)).drag_shift
    np.testing.assert_allclose(shift, 0.1 * fitted(Drag(0.0, DRAG_PER_M)).drag_shift, rtol=0.01)


@pytest.mark.parametrize("reference_s", [0.0, 0.04])
def test_drag_follows_the_speed_that_a_fall_changes(reference_s: float) -> None:
    # A bead of a millimetre at 250 frames/s: 0.3 m/s across, and 0.4 m/s downward after ten frames.
    drag_per_m, times = 0.3, np.linspace(0.0, 0.04, 11)
    flight = slowed_by_drag(drag_per_m, np.array([0.0, 0.3, 0.0]), 0.04)
    path = fit_flight(
        times,
        flight(times).T[:, :3],
        np.full((11, 3), 1e-6),
        NO_DRIFT,
        gravity=G,
        reference_s=reference_s,
        drag=Drag(drag_per_m, 0.1 * drag_per_m),
    )
    # With the drag of the speed at either end it is off by 2e-4.
    np.testing.assert_allclose(path.velocity, flight(reference_s)[3:], atol=2e-5)
    slowing = path.acceleration - G * DOWN
    speed = np.linalg.norm(path.velocity)
    np.testing.assert_allclose(slowing, -drag_per_m * speed * path.velocity, atol=1e-9)


def test_a_flight_bent_by_drag_that_is_badly_known_is_still_a_free_flight() -> None:
    times, rng = np.linspace(-0.04, 0.0, 11), np.random.default_rng(4)
    flight = slowed_by_drag(0.3, np.array([0.0, 0.3, 0.0]), 0.04)
    seen = flight(times + 0.04).T[:, :3]
    sigmas = np.full((11, 3), 2e-7)

    def chi2(sigma_per_m: float) -> float:
        noisy = seen + sigmas * rng.standard_normal(seen.shape)
        stated = Drag(0.2, sigma_per_m)
        return fit_flight(
            times, noisy, sigmas, NO_DRIFT, gravity=G, reference_s=0.0, drag=stated
        ).chi2_per_dof

    assert chi2(0.0) > 8.0
    assert np.mean([chi2(0.1) for _ in range(20)]) == pytest.approx(1.0, abs=0.25)


def test_two_frames_give_a_line_without_freedom() -> None:
    path = fit_flight(
        TIMES[:2], flown(TIMES, 0.0)[:2], SIGMAS[:2], NO_DRIFT, gravity=G, reference_s=0.0
    )
    np.testing.assert_allclose(path.velocity, VELOCITY, atol=1e-9)
    assert math.isnan(path.chi2_per_dof)
    assert np.isfinite(path.covariance).all()


@pytest.mark.parametrize(
    ("nearest", "velocity"),
    # X = 0, 2, 8 mm and Y = 0, 4, 8 mm at 0, 2 and 4 ms: X'' = 4 mm / (2 ms)^2 = 1000 m/s^2,
    # X' = 0, 2 and 4 m/s at the three frames, Y' = 2 m/s throughout.
    [(0, (0.0, 2.0, 0.0)), (-1, (4.0, 2.0, 0.0))],
)
def test_three_frames_worked_by_hand(nearest: int, velocity: tuple[float, ...]) -> None:
    times = np.array([0.0, 2e-3, 4e-3])
    positions = 1e-3 * np.array([[0.0, 0.0, 5.0], [2.0, 4.0, 5.0], [8.0, 8.0, 5.0]])
    path = three_frame_flight(times, positions, np.full((3, 3), 1e-5), NO_DRIFT, nearest)
    np.testing.assert_allclose(path.velocity, velocity, atol=1e-9)
    np.testing.assert_allclose(path.acceleration, (1000.0, 0.0, 0.0), atol=1e-6)
    np.testing.assert_allclose(path.position, positions[nearest])
    assert path.reference_s == times[nearest]
    # Velocity (-3 x1 + 4 x2 - x3) / (2 dt) at an end: sqrt(26) sigma / (2 dt).
    sigma = math.sqrt(26) * 1e-5 / 4e-3
    np.testing.assert_allclose(np.sqrt(np.diag(path.covariance))[3:], sigma)


def test_three_frames_with_a_lost_one_between_keep_their_own_times() -> None:
    times = np.array([0.0, 1e-3, 4e-3])
    positions = np.stack([VELOCITY * t + 0.5 * np.array([300.0, -50.0, 0.0]) * t**2 for t in times])
    path = three_frame_flight(times, positions, np.full((3, 3), 1e-5), NO_DRIFT, 0)
    np.testing.assert_allclose(path.velocity, VELOCITY, atol=1e-9)
    np.testing.assert_allclose(path.acceleration, (300.0, -50.0, 0.0), atol=1e-5)


@given(first=st.floats(-0.02, 0.02), second=st.floats(-0.02, 0.02))
def test_a_path_moved_to_another_time_is_the_same_path(first: float, second: float) -> None:
    path = fit(flown(TIMES, 4e-3))
    moved = path.moved_to(first)
    for one, other in zip(moved.at(second), path.at(second), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)
    np.testing.assert_allclose(moved.position, path.at(first)[0])
    direct = fit(flown(TIMES, 4e-3), reference_s=first)
    np.testing.assert_allclose(moved.covariance, direct.covariance, rtol=1e-6, atol=1e-18)


def test_a_path_falls_as_a_stone_does() -> None:
    path = FlightPath(1.0, np.zeros(3), np.zeros(3), G * DOWN, np.eye(6), 1.0, np.zeros(6))
    position, velocity = path.at(1.5)
    np.testing.assert_allclose(position, (0.5 * G * 0.25, 0.0, 0.0))
    np.testing.assert_allclose(velocity, (0.5 * G, 0.0, 0.0))
