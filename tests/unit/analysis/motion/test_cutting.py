"""Tracks are cut where they tear: free flight written down, and what is done to it."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.errors import ShotRefusedError
from analysis.motion.cutting import cut_tears, notes_of, refuse_jumps
from analysis.motion.poses import Centres

TIMES_S = np.arange(60) * 1e-3
CONTACT_S, TOUCH_M, SIGMA_M, GRAVITY = 29.4e-3, 0.0254, 4e-6, 9.8


def flight(side: float, seed: int = 0):
    """A sphere that meets another in the middle and parts with 0.7 of its speed, m, (60, 3)."""
    late = TIMES_S - CONTACT_S
    speed = np.where(late < 0, 1.5, -1.05)
    y = side * (TOUCH_M / 2 - speed * late)
    x = 0.5 * GRAVITY * TIMES_S**2 + np.where(late < 0, 0.0, side * 0.3 * late)
    noise = SIGMA_M * np.random.default_rng(seed).normal(size=(60, 3))
    return np.stack([x, y, 0.01 * late], axis=1) + noise


def seen(position, sigma=None):
    errors = np.full((60, 3), SIGMA_M) if sigma is None else sigma
    return Centres(np.arange(60), position, errors)


def cut(a, b, sigma=None):
    return cut_tears((seen(a, sigma), seen(b)), TIMES_S, GRAVITY, TOUCH_M)


@pytest.fixture
def pair():
    return flight(-1.0, 1), flight(1.0, 2)


def test_nothing_is_taken_from_free_flight(pair):
    assert cut(*pair) == ({}, {})


@pytest.mark.parametrize("begins", [36, 45, 57])
def test_a_track_that_runs_away_ends_where_it_begins_to(pair, begins):
    a, b = pair
    a[begins:, 2] += 1e-3 * np.arange(1, 61 - begins)
    of_a, of_b = cut(a, b)
    assert sorted(of_a) == list(range(begins, 60))
    assert of_b == {}


def test_a_sphere_that_touches_a_wall_keeps_its_flight_up_to_it(pair):
    a, b = pair
    b[44:, 1] = 2 * b[44, 1] - b[44:, 1]
    assert sorted(cut(a, b)[1]) == list(range(45, 60))


def test_a_sphere_that_leaves_its_tube_late_keeps_its_flight_from_there(pair):
    a, b = pair
    a[:10, 0] -= 0.3 * (TIMES_S[10] - TIMES_S[:10])
    assert sorted(cut(a, b)[0]) == list(range(10))


@pytest.mark.parametrize("lone", [3, 31, 50])
def test_a_lone_bad_frame_is_left_out_alone(pair, lone):
    a, b = pair
    a[lone, 0] += 3e-4
    assert list(cut(a, b)[0]) == [lone]


def test_a_frame_that_is_far_less_certain_than_its_track_is_left_out(pair):
    sigma = np.full((60, 3), SIGMA_M)
    sigma[50] *= 7
    (frame, reason), *others = cut(*pair, sigma)[0].items()
    assert (frame, others) == (50, [])
    assert "6 times" in reason


def test_a_coordinate_that_was_not_measured_is_no_fault(pair):
    a, b = pair
    sigma = np.full((60, 3), SIGMA_M)
    sigma[40:, 2], a[40:, 2] = np.inf, np.nan
    assert cut(a, b, sigma) == ({}, {})


def test_frames_in_which_the_spheres_press_each_other_are_left_out_for_both(pair):
    a, b = pair
    for own, side in ((a, -1.0), (b, 1.0)):
        own[34:, 1] = own[30:56, 1]
        own[30:34, 1] = side * (TOUCH_M / 2 - 5e-4)
    of_a, of_b = cut(a, b)
    assert sorted(of_a) == sorted(of_b) == [30, 31, 32, 33]
    assert "pressed" in of_a[30]


def test_a_coordinate_that_one_sphere_hides_presses_nobody(pair):
    a, b = pair
    a[31:36, 1] = np.nan
    sigma = np.where(np.isfinite(a), SIGMA_M, np.inf)
    assert cut(a, b, sigma) == ({}, {})


def test_tracks_that_jump_together_while_apart_are_refused(pair):
    a, b = (np.concatenate([own[:45], own[46:], own[-1:]]) for own in pair)
    with pytest.raises(ShotRefusedError, match="lost, repeated or exchanged") as refusal:
        refuse_jumps((seen(a), seen(b)), cut(a, b), TOUCH_M)
    assert refusal.value.frame == 45


def test_spheres_that_never_come_near_are_left_to_others(pair):
    a, b = pair
    assert cut(a - [0.0, 0.02, 0.0], b) == ({}, {})


def test_frames_in_a_row_share_a_line():
    lines = notes_of("a", {4: "dark", 5: "dark", 7: "dark", 8: "torn"})
    assert lines == (
        "frames 4–5, 7 left out for sphere a: dark",
        "frame 8 left out for sphere a: torn",
    )


def test_beads_that_the_air_slows_by_a_tenth_keep_their_flights():
    """Of 1.7 mm, 8 radii from frame to frame: v = V / (1 + k V t), placed to 0.7 micrometres."""
    rate_hz, diameter_m, slows_per_m, speed = 250.0, 1.7e-3, 0.165, 1.75
    times_s = np.arange(20) / rate_hz
    contact_s, sigma_m = 9.97 / rate_hz, 0.7e-6
    late = times_s - contact_s
    paths = []
    for side, seed in ((-1.0, 1), (1.0, 2)):
        way = np.sign(late) * np.log1p(slows_per_m * speed * np.abs(late)) / slows_per_m
        coming = -np.log1p(-slows_per_m * speed * np.minimum(-late, 0.3)) / slows_per_m
        y = side * (diameter_m / 2 + np.where(late < 0, coming, 0.7 * way))
        noise = sigma_m * np.random.default_rng(seed).normal(size=(20, 3))
        position = np.stack([0.5 * GRAVITY * times_s**2, y, 0.0 * y], axis=1) + noise
        paths.append(Centres(np.arange(20), position, np.full((20, 3), sigma_m)))
    assert cut_tears((paths[0], paths[1]), times_s, GRAVITY, diameter_m) == ({}, {})
