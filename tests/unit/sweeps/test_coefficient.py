"""Means of a coefficient, where the next shot tells most, and the time that is left."""

from __future__ import annotations

import math

import numpy as np
import pytest
from bench import Bench, plan, settings
from hypothesis import given
from hypothesis import strategies as st

from rigctl.store import StepState, SweepState
from rigctl.sweeps.coefficient import Estimate, estimate_in, mean_of
from rigctl.sweeps.plan import Rules, Until
from rigctl.sweeps.run import SPREAD, Pace, best

VALUES = st.floats(-1.0, 1.0)
SIGMAS = st.floats(1e-3, 1.0)


def test_shots_that_agree_have_the_error_of_their_weights() -> None:
    mean = mean_of("e", [Estimate(0.74, 0.01), Estimate(0.74, 0.02), Estimate(0.74, 0.02)])
    assert mean is not None
    # Weights 10000, 2500, 2500: the error is 1 / sqrt(15000).
    assert (mean.value, mean.shots) == (pytest.approx(0.74), 3)
    assert mean.sigma == pytest.approx(0.00816497, rel=1e-5)


def test_shots_that_scatter_have_the_error_of_their_scatter() -> None:
    values = [0.70, 0.72, 0.74, 0.76, 0.78]
    mean = mean_of("e", [Estimate(value, 1e-4) for value in values])
    assert mean is not None
    assert mean.sigma == pytest.approx(np.std(values, ddof=1) / math.sqrt(5), rel=1e-9)


def test_no_number_of_shots_reduces_what_all_of_them_share() -> None:
    mean = mean_of("e", [Estimate(0.74, 1e-3, common=5e-4)] * 100)
    assert mean is not None
    assert (mean.own, mean.common) == (pytest.approx(1e-4), pytest.approx(5e-4))
    assert mean.sigma == pytest.approx(np.hypot(1e-4, 5e-4))
    split = {"value": 0.74, "sigma": 0.05, "sigma_own": 0.04, "sigma_common": 0.03}
    assert estimate_in({"e": split}, "e") == Estimate(0.74, 0.04, 0.03)


def test_fewer_than_three_shots_state_no_error() -> None:
    assert mean_of("e", []) is None
    two = mean_of("e", [Estimate(0.7, 0.01), Estimate(0.8, 0.01)])
    assert two is not None
    assert (two.value, two.sigma) == (pytest.approx(0.75), None)


@given(st.lists(st.tuples(VALUES, SIGMAS), min_size=3, max_size=20))
def test_a_mean_lies_among_its_shots_and_is_no_surer_than_all_of_them_together(
    shots: list[tuple[float, float]],
) -> None:
    mean = mean_of("e", [Estimate(*shot) for shot in shots])
    assert mean is not None
    assert mean.sigma is not None
    values = [value for value, _ in shots]
    assert min(values) - 1e-12 <= mean.value <= max(values) + 1e-12
    assert mean.sigma >= sum(sigma**-2 for _, sigma in shots) ** -0.5 * (1 - 1e-12)


@pytest.mark.parametrize(
    "quantity",
    [
        None,
        {"value": 0.7, "sigma": 0.0},
        {"value": 0.7, "sigma": math.inf},
        {"value": 0.7, "sigma": None},
        {"value": None, "sigma": None},
    ],
)
def test_a_result_without_a_usable_error_tells_nothing(quantity: object) -> None:
    assert estimate_in({"e": quantity}, "e") is None
    assert estimate_in({}, "e") is None


def test_the_first_shots_follow_the_order_of_the_sweep() -> None:
    waiting = [settings(offset) for offset in (5.0, 6.0)]
    told = [(settings(float(k)), 1.0 if k == 6 else 0.0) for k in range(SPREAD - 1)]
    assert best(waiting, told) == 0
    assert best(waiting, [*told, (settings(20.0), 0.0)]) == 1


def test_the_next_shot_goes_where_its_neighbours_told_most() -> None:
    waiting = [settings(offset, pressure) for offset in (0.0, 10.0, 20.0) for pressure in (20, 80)]
    told = [
        (settings(offset, pressure), 1e4 if (offset, pressure) == (12.0, 70.0) else 1.0)
        for offset in (1.0, 12.0, 19.0)
        for pressure in (30.0, 50.0, 70.0)
    ]
    assert waiting[best(waiting, told)] == settings(10.0, 80)


def test_an_adaptive_sweep_fires_where_shots_can_be_measured(bench: Bench) -> None:
    def measure_what_is_stored() -> None:
        for shot in bench.lab.store.shots(limit=500):
            if shot.state == "stored":
                glancing = shot.settings.offset_mm > 10.0
                bench.measure(shot.id, 0.74, 1.0 if glancing else 0.01)

    bench.on_idle = measure_what_is_stored
    # Every seventh of twenty: the first eight lie all over the range.
    offsets = [float(7 * k % 20 + 1) for k in range(60)]
    rules = Rules(pause_s=1.0, until=Until("e", 0.00202), adaptive=True)
    done = bench.run(plan(offsets, rules))
    assert done.record.state is SweepState.COMPLETED
    fired = [shot.settings.offset_mm for shot in bench.lab.store.shots(limit=500)]
    # 25 shots of 0.01 make 0.00200, 24 make 0.00204, and none at more than 10 mm tells a thing.
    glancing = [offset for offset in fired if offset > 10.0]
    assert len(fired) == 25 + len(glancing)
    assert len(glancing) == sum(offset > 10.0 for offset in offsets[:SPREAD])
    assert done.record.counts[StepState.SKIPPED] == 60 - len(fired)


def test_time_left_follows_the_last_steps() -> None:
    pace = Pace(0.0)
    assert pace.left_s(5) is None
    pace.step_ended(2.0)
    assert pace.left_s(5) == 10.0
    for k in range(16):
        pace.step_ended(3.0 + k)
    assert pace.left_s(5) == 5.0
    assert pace.left_s(0) == 0.0
