"""A campaign in parts is fitted and ranked to the numbers that it has in memory."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from analysis.effects.clock.timing_jitter import EFFECT as JITTER
from analysis.model.data.inside import without_contact_frames
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.fitting.robust_fit import judged
from analysis.model.fitting.summary import FitSummary
from analysis.model.rank.candidate import Ranking
from analysis.model.rank.ranking import rank, rank_over
from analysis.model.streaming.fit import fit_stream, passes_of_stream
from analysis.model.streaming.judged import judged_stream
from analysis.model.streaming.stream import PoseStream
from tests.unit.analysis.model.chosen import EFFECTS, chosen
from tests.unit.analysis.model.hard_spheres import Hidden, campaign
from tests.unit.analysis.model.streaming.parts import in_parts, streamed

SHOTS = 300
LAW = (0.74, 0.08, 0.5)
JITTER_S = 2e-5
WELL_BELOW = 1e-3
"""Standard errors."""


@pytest.fixture(scope="module")
def data() -> PoseData:
    return without_contact_frames(campaign(SHOTS, 31, LAW, hidden=Hidden(slope=0.01)))


@pytest.fixture(scope="module")
def fit(data: PoseData) -> Fit:
    return fit_campaign(data)


def assert_same_fit(found: FitSummary, wanted: FitSummary) -> None:
    assert found.theory.names == wanted.theory.names
    sigma = np.sqrt(np.diag(wanted.covariance))
    off = (found.theory.vector - wanted.theory.vector) / sigma
    assert np.abs(off).max() < WELL_BELOW
    np.testing.assert_allclose(found.covariance, wanted.covariance, rtol=1e-3)
    assert found.chi2 == pytest.approx(wanted.chi2, abs=0.01)
    assert (found.residuals, found.freedom) == (wanted.residuals, wanted.freedom)
    np.testing.assert_allclose(found.shot_chi2, wanted.shot_chi2, rtol=1e-3)
    assert found.converged


def assert_same_ranking(found: Ranking, wanted: Ranking) -> None:
    names = [candidate.effect.name for candidate in wanted.candidates]
    assert [candidate.effect.name for candidate in found.candidates] == names
    for one, other in zip(found.candidates, wanted.candidates, strict=True):
        assert (one.seen, one.plausible) == (other.seen, other.plausible)
        assert one.carriers == other.carriers
        assert one.carried_share == pytest.approx(other.carried_share, rel=1e-3, abs=1e-6)
        assert one.score == pytest.approx(other.score, abs=WELL_BELOW)
        assert one.p_familywise == pytest.approx(other.p_familywise, abs=1e-3)
        np.testing.assert_allclose(one.sigmas, other.sigmas, rtol=1e-3)
    np.testing.assert_allclose(found.aliases, wanted.aliases, atol=1e-3)
    np.testing.assert_allclose(found.imitated, wanted.imitated, atol=1e-3)
    assert found.noise_scale == pytest.approx(wanted.noise_scale)


@pytest.mark.parametrize("lengths", [(128,), (1, 40, 200, 59)])
def test_however_long_the_parts_are_fit_and_ranking_are_those_in_memory(
    data: PoseData, fit: Fit, lengths: tuple[int, ...]
) -> None:
    stream = streamed(data, *lengths)
    found = fit_stream(stream)
    assert_same_fit(found, fit)
    effects = (*EFFECTS, JITTER)
    assert_same_ranking(
        rank_over(passes_of_stream(stream, found), effects), rank(data, fit, effects)
    )


def test_parts_may_have_frames_of_their_own_number(data: PoseData, fit: Fit) -> None:
    padded = []
    for k, part in enumerate(in_parts(data, (90,))):
        padded.append(with_empty_frames(part, k))
    assert_same_fit(fit_stream(PoseStream.of(padded)), fit)


def test_the_law_comes_out_within_its_errors() -> None:
    found = fit_stream(streamed(without_contact_frames(campaign(SHOTS, 32, LAW)), 70))
    sigma = np.sqrt(np.diag(found.covariance))
    assert np.abs((found.theory.vector - LAW) / sigma).max() < 4


def test_bad_shots_frames_and_sigmas_are_judged_as_in_memory() -> None:
    stated = spoilt(campaign(60, 33, LAW)).with_sigmas(
        np.full((60, 24, 2, 3), 3e-5), np.full((60, 24, 2), 8e-3)
    )
    wanted, found = judged(stated), judged_stream(streamed(stated, 25))
    assert wanted.account.rejected == [12]
    assert wanted.account.frames == ((8, 3),)
    assert wanted.account.noise[0] == pytest.approx(2 / 3, abs=0.02)
    assert (found.account.rejected, found.account.frames) == ([12], ((8, 3),))
    assert found.account.noise == pytest.approx(wanted.account.noise, rel=1e-6)
    assert_same_fit(found.fit, wanted.fit)
    assert_same_ranking(found.ranked(EFFECTS), rank(wanted.data, wanted.fit, EFFECTS))


@pytest.mark.long
def test_effects_are_added_as_in_memory_those_of_the_noise_too() -> None:
    stated = spoilt(jittered(campaign(40, 34, LAW, hidden=Hidden(slope=0.03))))
    effects = [*chosen("restitution-viscoelastic"), JITTER]
    wanted, found = judged(stated, effects), judged_stream(streamed(stated, 15), effects)
    assert found.account == wanted.account
    assert wanted.data.jitter_s == pytest.approx(JITTER_S, rel=0.2)
    assert found.data.jitter_s == pytest.approx(wanted.data.jitter_s, rel=1e-6)
    assert_same_fit(found.fit, wanted.fit)
    assert found.fit.parameters().keys() == wanted.fit.parameters().keys()
    assert_same_ranking(found.ranked(EFFECTS), rank(wanted.data, wanted.fit, EFFECTS))


def test_memory_does_not_grow_with_the_number_of_shots() -> None:
    few, many = (peak(campaign(shots, 35, LAW)) for shots in (64, 320))
    # Poses of the further shots alone have 1.6 MB, the sums of their fit 1.2 MB.
    assert many < few + 3e5


def peak(data: PoseData) -> int:
    """Return the most memory that fit and ranking allocate, bytes."""
    stream = streamed(data, 32)
    del data
    tracemalloc.start()
    try:
        fit = fit_stream(stream)
        rank_over(passes_of_stream(stream, fit), chosen("image-scale"))
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def with_empty_frames(part: PoseData, count: int) -> PoseData:
    """Return the data with frames at the end in which nothing was measured."""

    def longer(numbers: np.ndarray, **how: float) -> np.ndarray:
        width = [(0, 0), (0, count), *[(0, 0)] * (numbers.ndim - 2)]
        return np.pad(numbers, width, mode="constant" if how else "edge", **how)

    return replace(
        part,
        times_s=longer(part.times_s),
        position=longer(part.position),
        position_sigma=longer(part.position_sigma, constant_values=np.inf),
        rotation=longer(part.rotation),
        rotation_sigma=longer(part.rotation_sigma, constant_values=np.inf),
    )


def jittered(data: PoseData) -> PoseData:
    """Return the data with every frame taken a little early or late."""
    off = np.random.default_rng(3).normal(0, JITTER_S, data.times_s.shape)
    return replace(data, times_s=data.times_s + off)


def spoilt(data: PoseData) -> PoseData:
    """Return the data with frame 3 of shot 8 wild, and sphere a of shot 12 followed in a bend."""
    position = data.position.copy()
    position[7, 3, 1] += [0.0, 1.5e-3, 0.0]
    position[11, :, 0, 1] += 4e-4 * np.sin(np.arange(position.shape[1]) / 2)
    return replace(data, position=position)
