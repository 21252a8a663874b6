"""Flights of a filmed ball that its camera bends are no sign of frames that come early or late."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.effects.clock.jitter_score import JitterScore
from analysis.model.data.gather import gather
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.rank.scatter import timing_jitter
from analysis.setup import SlowErrors
from simulators.challenge.drops import Drop
from tests.unit.analysis.model.dropped import write_drops

SIGMA_M, BEND_M, JITTER_S = 1e-5, 3e-4, 2e-5
"""Of a place; what a lens and a line of sight do at 0.3 m over the plate; of a frame's time."""


@pytest.fixture(scope="module")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> PoseData:
    folder = write_drops(
        Path(tmp_path_factory.mktemp("bent")) / "drops",
        Drop(drag_coefficient=0.45),
        shots=5,
        seed=9,
        heights_m=(0.15, 0.4),
        sideways=0.02,
        spinning=0.0,
        markers=False,
        lasts_s=0.8,
        rate_hz=250.0,
        sigma_m=SIGMA_M,
    )
    data = gather(folder)[1]
    assert isinstance(data, PoseData)
    return replace(data, slow=SlowErrors(position_m=2 * BEND_M))


def bent(data: PoseData) -> PoseData:
    """Bend heights as a lens and a line of sight do: by squares and cubes of them."""
    height = data.position[:, :, 0, 0] / 0.3
    position = data.position.copy()
    position[:, :, 0, 0] += BEND_M * (height**2 + height**3)
    return replace(data, position=position)


def score(data: PoseData) -> JitterScore:
    found = timing_jitter(data, fit_campaign(data))
    assert found is not None
    return found


def test_flights_that_bend_by_stated_slow_errors_show_no_jitter(filmed: PoseData) -> None:
    assert score(bent(filmed)).p_value > 1e-3
    # The same without a word of slow errors: something moves as frames of uncertain time do.
    assert score(replace(bent(filmed), slow=SlowErrors())).p_value < 1e-6


def test_frames_of_uncertain_time_are_found_in_flights_that_bend(filmed: PoseData) -> None:
    data = bent(filmed)
    late = np.random.default_rng(2).normal(0.0, JITTER_S, data.times_s.shape)
    found = score(replace(data, times_s=data.times_s + late))
    assert found.p_value < 1e-6
    assert found.amplitude == pytest.approx(JITTER_S, abs=4 * found.sigma)
