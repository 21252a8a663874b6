"""Jitter of the frames' times is found as noise of its own, with its size, and put in as such."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.clock.timing_jitter import EFFECT
from analysis.model.data.poses import PoseData
from analysis.model.fitting.adding import added
from analysis.model.fitting.fit import fit_campaign
from analysis.model.rank.ranking import rank
from analysis.model.rank.scatter import timing_jitter
from analysis.model.verdict.selection import explain
from tests.unit.analysis.model.hard_spheres import campaign

JITTER_S = 1.5e-5


def jittered(shots: int, seed: int, sigma_s: float) -> PoseData:
    """Return a campaign whose frames were taken a little early or late."""
    data = campaign(shots, seed)
    late = np.random.default_rng(seed).normal(0, sigma_s, data.times_s.shape)
    interval = np.diff(data.times_s[0, :2])[0]
    velocity = np.gradient(data.position, axis=1) / interval
    turned = (
        Rotation.from_matrix(data.rotation[:, 1:].reshape(-1, 3, 3))
        * Rotation.from_matrix(data.rotation[:, :-1].reshape(-1, 3, 3)).inv()
    )
    spin = turned.as_rotvec().reshape(shots, -1, 2, 3) / interval
    spin = np.concatenate([spin[:, :1], spin], axis=1)
    more = Rotation.from_rotvec((spin * late[..., None, None]).reshape(-1, 3)).as_matrix()
    return replace(
        data,
        position=data.position + velocity * late[..., None, None],
        rotation=more.reshape(data.rotation.shape) @ data.rotation,
    )


def test_its_size_is_found_and_chi_squared_is_one_with_it() -> None:
    data = jittered(60, 3, JITTER_S)
    fit = fit_campaign(data)
    assert fit.chi2_per_dof > 1.1
    whole, again = added(data, fit, EFFECT)
    size = again.parameters()["timing-jitter.s"]
    # A gradient over two frames carries the noise of both; it swells the jitter by a little.
    assert size.value == pytest.approx(JITTER_S, rel=0.1)
    assert again.chi2_per_dof == pytest.approx(1.0, abs=5 * np.sqrt(2 / again.freedom))
    assert isinstance(whole, PoseData)
    assert whole.jitter_s == size.value


def test_where_frames_are_on_time_none_is_claimed() -> None:
    ranks = []
    for seed in range(6):
        data = campaign(30, 100 + seed)
        score = timing_jitter(data, fit_campaign(data))
        assert score is not None
        ranks.append(score.p_value)
    assert min(ranks) > 1e-3


def test_it_is_the_verdict_where_it_is_hidden() -> None:
    verdict = explain(jittered(40, 5, JITTER_S), CATALOGUE)
    assert verdict.effects == ("timing-jitter",)
    size = verdict.fit.parameters()["timing-jitter.s"]
    assert size.value == pytest.approx(JITTER_S, rel=0.15)
    assert verdict.verdict == "effect"


def test_a_fit_with_jitter_does_not_rank_it_again() -> None:
    data = jittered(30, 6, JITTER_S)
    ranking = rank(*added(data, fit_campaign(data), EFFECT), CATALOGUE)
    assert "timing-jitter" not in {c.effect.name for c in ranking.candidates}
