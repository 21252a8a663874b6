"""Frames inside contact are left out, for as long as a Hertzian contact lasts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from analysis.collision.contact_frames import longest_contact
from analysis.collision.operator import Body
from analysis.model.data.inside import without_contact_frames
from tests.unit.analysis.model.hard_spheres import campaign, draw

NYLON = Body.sphere(0.0254, 1150.0, 0.4)
MASS = 1150.0 * np.pi / 6 * 0.0254**3
STIFFNESS = 4 / 3 * (2.3e9 / (2 * (1 - 0.25**2))) * np.sqrt(0.0127 / 2)
DENSE_S = 5e-5
CLOSE_S = 2.5e-5


def integrated(speed: float) -> float:
    """Return how long two spheres with F = k x^1.5 stay in touch, s, by an ODE solver."""

    def motion(_: float, state: list[float]) -> list[float]:
        return [state[1], -STIFFNESS * max(state[0], 0.0) ** 1.5 / (MASS / 2)]

    def parted(_: float, state: list[float]) -> float:
        return state[0] if state[1] < 0 else 1.0

    parted.terminal = True
    done = solve_ivp(motion, (0, 1e-2), [0.0, speed], events=parted, rtol=1e-9, atol=1e-15)
    return float(done.t[-1])


@pytest.mark.parametrize("speed", [0.3, 1.0, 3.0, 6.0])
def test_the_duration_is_that_of_an_integrated_contact(speed: float) -> None:
    [closed] = longest_contact(np.array([speed]), (NYLON, NYLON))
    assert closed == pytest.approx(integrated(speed), rel=2e-3)


def test_slow_contacts_last_longer_by_the_fifth_root_and_never_for_ever() -> None:
    slow, fast = longest_contact(np.array([0.1, 3.2]), (NYLON, NYLON))
    assert slow / fast == pytest.approx(2.0, rel=1e-9)
    grazing = longest_contact(np.array([0.0, -1.0]), (NYLON, NYLON))
    assert np.array_equal(grazing, longest_contact(np.array([0.05, 0.05]), (NYLON, NYLON)))


@pytest.mark.parametrize("exposure_s", [0.0, 2e-4])
def test_frames_from_just_before_first_touch_to_well_after_separation_are_left_out(
    exposure_s: float,
) -> None:
    data = campaign(40, 8, interval_s=DENSE_S)
    data = replace(data, camera=replace(data.camera, exposure_s=exposure_s))
    drawn = draw(np.random.default_rng(8), 40, DENSE_S)
    approach = ((drawn.velocity[:, 0] - drawn.velocity[:, 1]) * drawn.normal).sum(axis=1)
    lasting = np.array([1.6 * integrated(v) for v in approach])
    tau = data.times_s - drawn.contact_s[:, None]
    first, last = -6e-5 - exposure_s / 2, lasting[:, None] + exposure_s / 2
    kept = without_contact_frames(data).measured.all(axis=(2, 3))
    inside = (tau > first + CLOSE_S) & (tau < last - CLOSE_S)
    outside = (tau < first - CLOSE_S) | (tau > last + CLOSE_S)
    assert inside.sum() > 100
    # A grazing line of sight makes a first guess of the instant late or early by more than that.
    assert kept[inside].mean() < 0.01
    assert kept[outside].mean() > 0.99


def test_frames_a_millisecond_apart_lose_at_most_the_one_that_holds_the_contact() -> None:
    data = campaign(60, 8)
    lost = ~without_contact_frames(data).measured.all(axis=(2, 3))
    drawn = draw(np.random.default_rng(8), 60)
    assert lost.sum(axis=1).max() <= 1
    assert np.abs((data.times_s - drawn.contact_s[:, None])[lost]).max() < 5e-4
