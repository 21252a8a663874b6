"""The simulated apparatus against its own truth, by arithmetic that shares nothing with it."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from simulators.qualification import disk, drop, filmed_drop, filmed_shot, stage_run, turning_disk


def weighted_centre(picture: np.ndarray, background: float) -> tuple[float, float]:
    weight = np.clip(picture.astype(float) - background, 0.0, None)
    weight[weight < 15.0] = 0.0
    rows, columns = np.indices(picture.shape)
    return (
        float((weight * rows).sum() / weight.sum()),
        float((weight * columns).sum() / weight.sum()),
    )


@pytest.mark.parametrize("direction", [(0.0, 1.0), (1.0, 0.0), (1.0, 1.0)])
def test_the_stage_moves_the_sphere_by_quarters_of_a_pixel(direction: tuple[float, float]) -> None:
    run = stage_run(direction, seed=3)
    assert run.frames.shape == (9, 192, 240)
    np.testing.assert_allclose(run.moved_px, np.outer(np.arange(9) / 4, direction))
    centres = np.array([weighted_centre(frame, 50.0) for frame in run.frames])
    np.testing.assert_allclose(centres - centres[0], run.moved_px, atol=0.08)


def test_the_fall_obeys_its_equation_of_motion() -> None:
    radius = drop.DIAMETER_M / 2
    volume, area = 4 / 3 * math.pi * radius**3, math.pi * radius**2
    mass = drop.STEEL_KG_PER_M3 * volume

    def motion(_: float, state: np.ndarray) -> list[float]:
        weight = (mass - drop.AIR_KG_PER_M3 * volume) * drop.GRAVITY_M_PER_S2
        drag = 0.5 * drop.AIR_KG_PER_M3 * drop.DRAG_COEFFICIENT * area * state[1] ** 2
        return [state[1], (weight - drag) / mass]

    solved = solve_ivp(motion, (0.0, 0.1), [0.0, 0.0], rtol=1e-10, atol=1e-12)
    assert drop.fallen_m(0.1) == pytest.approx(solved.y[0, -1], rel=1e-7)
    assert drop.fallen_m(0.0) == drop.fallen_m(-1.0) == 0.0


def test_the_film_of_a_drop_shows_the_fall() -> None:
    filmed = filmed_drop(5)
    assert filmed.frames.shape == (12, 192, 240)
    rows = np.array([weighted_centre(frame, 50.0)[0] for frame in filmed.frames])
    scale = drop.DIAMETER_PX / drop.DIAMETER_M
    parabola = np.polyfit(filmed.times_s, rows, 2)
    assert 2 * parabola[0] / scale == pytest.approx(filmed.gravity_m_per_s2, rel=0.01)


def test_the_disk_turns_by_the_stated_angle() -> None:
    filmed = turning_disk(1)
    assert math.degrees(filmed.turn_rad) == pytest.approx(997 / 60 * 360 / 1000)
    assert filmed.frames.shape == (15, 192, 240)
    dark = (filmed.frames < 100).astype(np.uint8)
    rows, columns = np.indices(dark.shape[1:])
    inside = np.hypot(rows - disk.CENTRE_PX[0], columns - disk.CENTRE_PX[1]) < 76
    angles = []
    for frame in dark:
        own = frame.astype(bool) & inside
        turned = np.arctan2(columns[own] - 120, rows[own] - 96)
        # The five markers are not evenly spread, so the first harmonic turns with the disk.
        angles.append(np.angle(np.exp(1j * turned).sum()))
    steps = np.diff(np.unwrap(angles))
    assert steps.mean() == pytest.approx(filmed.turn_rad, rel=0.02)


def test_shots_of_one_seed_differ_by_their_settings_and_repeat_by_their_number() -> None:
    first, again, other = filmed_shot(0, 4), filmed_shot(0, 4), filmed_shot(1, 4)
    np.testing.assert_array_equal(first.frames, again.frames)
    assert (first.frames != other.frames).any()
