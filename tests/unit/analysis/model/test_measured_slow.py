"""Slow errors of poses are as large as all flights of a campaign show, whatever is stated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.model.data.poses import PoseData
from analysis.model.data.stream import PoseStream
from analysis.model.fitting.slow_errors.sizes import with_measured_slow_errors
from analysis.setup import SlowErrors
from tests.unit.analysis.model.hard_spheres import RADIUS, campaign

TRUE_M = 3e-6
TURN_PER_M = 1.5 / RADIUS
MEMORY_RAD = 0.3


def filmed(
    shots: int,
    true_m: float,
    stated_m: float,
    *,
    interval_s: float = 1e-3,
    depth: float = 1.0,
    turned_by: float = 1.0,
) -> PoseData:
    """Return a campaign with slow errors that forget themselves while a sphere turns by 0.3 rad.

    Those of Z and of turns are larger than of X and Y by `depth` and `turned_by`.
    """
    noise = {"position_sigma": 2e-6, "rotation_sigma": 4e-4}
    data = campaign(shots, 51, interval_s=interval_s, **noise)
    rng = np.random.default_rng(52)
    places = np.zeros_like(data.position)
    turns = np.zeros_like(data.position)
    for shot, sphere in np.ndindex(shots, 2):
        times, rotation = data.times_s[shot], data.rotation[shot, :, sphere]
        steps = Rotation.from_matrix(rotation[1:] @ rotation[:-1].swapaxes(1, 2)).magnitude()
        turned = np.maximum(np.median(steps), 1e-3) * np.arange(len(times)) / MEMORY_RAD
        lasting = np.exp(-np.abs(turned[:, None] - turned)) + 1e-9 * np.eye(len(times))
        root = np.linalg.cholesky(lasting)
        drawn = true_m * root @ rng.normal(size=(len(times), 6))
        places[shot, :, sphere] = drawn[:, :3] * (1.0, 1.0, depth)
        turns[shot, :, sphere] = TURN_PER_M * turned_by * drawn[:, 3:]
    seen = Rotation.from_rotvec(turns.reshape(-1, 3)).as_matrix().reshape(data.rotation.shape)
    slow = SlowErrors(stated_m, TURN_PER_M * stated_m, 2e-5, memory_rad=MEMORY_RAD)
    return replace(data, position=data.position + places, rotation=seen @ data.rotation, slow=slow)


@pytest.mark.parametrize("stated", [0.5, 1.0, 2.0])
def test_forty_shots_find_the_size_whatever_is_stated(stated: float) -> None:
    stated_m = stated * TRUE_M
    found = with_measured_slow_errors(filmed(40, TRUE_M, stated_m)).slow
    (x, y, z), turns = found.sizes
    assert x == y
    assert (x, z) == pytest.approx((TRUE_M, TRUE_M), rel=0.25)
    assert turns == pytest.approx([TURN_PER_M * TRUE_M] * 3, rel=0.25)


@pytest.mark.parametrize(("depth", "turned_by"), [(2.0, 1.0), (1.0, 2.0), (0.5, 1.0)])
def test_depth_and_turns_have_sizes_of_their_own(depth: float, turned_by: float) -> None:
    data = filmed(40, TRUE_M, TRUE_M, depth=depth, turned_by=turned_by)
    (x, _, z), (turns, _, _) = with_measured_slow_errors(data).slow.sizes
    assert x == pytest.approx(TRUE_M, rel=0.25)
    assert z == pytest.approx(depth * TRUE_M, rel=0.3)
    assert turns == pytest.approx(turned_by * TURN_PER_M * TRUE_M, rel=0.25)


def test_a_few_shots_with_far_larger_errors_leave_the_sizes_of_the_others() -> None:
    data, odd = (filmed(36, size, TRUE_M) for size in (TRUE_M, 12.0 * TRUE_M))
    few = np.arange(36) % 6 == 0
    mixed = replace(
        data,
        position=np.where(few[:, None, None, None], odd.position, data.position),
        rotation=np.where(few[:, None, None, None, None], odd.rotation, data.rotation),
    )
    (x, _, z), (turns, _, _) = with_measured_slow_errors(mixed).slow.sizes
    assert (x, z, turns / TURN_PER_M) == pytest.approx((TRUE_M, TRUE_M, TRUE_M), rel=0.5)


def test_spheres_that_turn_by_several_radians_in_a_flight_show_the_size_too() -> None:
    data = filmed(40, TRUE_M, TRUE_M, interval_s=6e-3)
    steps = Rotation.from_matrix(
        (data.rotation[:, 1] @ np.swapaxes(data.rotation[:, 0], 2, 3)).reshape(-1, 3, 3)
    ).magnitude()
    assert np.quantile(steps, 0.9) * data.times_s.shape[1] / 2 > 6.0  # rad in half of a film
    found = with_measured_slow_errors(data).slow
    assert found.position_m == pytest.approx(TRUE_M, rel=0.2)


def test_what_all_flights_share_stays_as_it_is_stated() -> None:
    data = filmed(12, TRUE_M, 2.0 * TRUE_M)
    found = with_measured_slow_errors(data).slow
    assert (found.shared_m, found.common_m) == (data.slow.shared_m, data.slow.common_m)
    assert found.common_rad == pytest.approx(data.slow.common_rad)


def test_poses_without_slow_errors_show_none() -> None:
    found = with_measured_slow_errors(filmed(40, 0.0, TRUE_M)).slow
    assert found.position_m < TRUE_M / 3


def test_where_none_are_stated_none_are_looked_for() -> None:
    data = campaign(6, 53)
    assert with_measured_slow_errors(data) is data


def test_flights_too_short_for_it_leave_what_is_stated() -> None:
    data = filmed(6, TRUE_M, TRUE_M)
    short = data.without(np.arange(24)[None].repeat(6, 0) % 3 > 0)
    assert with_measured_slow_errors(short) is short


def test_what_flights_share_is_no_less_than_stated_where_flights_show_less() -> None:
    data = filmed(12, TRUE_M / 4, TRUE_M)
    found = with_measured_slow_errors(data).slow
    assert found.position_m < TRUE_M
    assert found.common_m == data.slow.common_m
    assert found.common_rad == pytest.approx(data.slow.common_rad)


def test_markers_in_every_second_frame_show_the_size_too() -> None:
    data = filmed(40, TRUE_M, TRUE_M)
    every_second = np.where(np.arange(data.rotation_sigma.shape[1]) % 2, np.inf, 1.0)
    thinned = replace(data, rotation_sigma=data.rotation_sigma * every_second[None, :, None])
    assert with_measured_slow_errors(thinned).slow.position_m == pytest.approx(TRUE_M, rel=0.3)


def test_a_campaign_read_in_parts_has_the_same_size() -> None:
    data = filmed(12, TRUE_M, TRUE_M / 2)
    parts = [data.of_shots(np.arange(12) < 5), data.of_shots(np.arange(12) >= 5)]
    found = with_measured_slow_errors(PoseStream.of(parts)).slow
    assert found.position_m == pytest.approx(with_measured_slow_errors(data).slow.position_m)
    assert found.varying == pytest.approx(with_measured_slow_errors(data).slow.varying)
