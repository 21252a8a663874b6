"""A campaign in a file is fitted, cleaned, ranked and explained to the digits it has in memory."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.clock.timing_jitter import EFFECT as JITTER
from analysis.effects.contact.lasting_contact import EFFECT as LASTING
from analysis.effects.effect import Effect
from analysis.model.data import parts
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, PoseStream
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.fitting.robust_fit import RobustFit, robust_fit
from analysis.model.rank.candidate import Ranking
from analysis.model.rank.ranking import rank
from analysis.model.verdict.documents import verdict_document
from analysis.model.verdict.selection import Verdict, explain
from benchmarks.discovery.campaigns import posed
from simulators.challenge.campaign import run_campaign
from simulators.challenge.force_choice import Forces
from simulators.challenge.nature import Nature
from tests.unit.analysis.model.chosen import EFFECTS, chosen
from tests.unit.analysis.model.data.parts import in_parts, streamed
from tests.unit.analysis.model.hard_spheres import Hidden, campaign

LAW = (0.74, 0.08, 0.5)
JITTER_S = 2e-5
SIZES = [5, 8, 40, 300]
"""Shots: of few several starts are fitted, and the largest has more than one part."""


def assert_same_fit(found: Fit, wanted: Fit) -> None:
    assert found.theory.names == wanted.theory.names
    for name in ("chi2", "residuals", "freedom", "converged", "scatter"):
        assert getattr(found, name) == getattr(wanted, name), name
    for name in ("covariance", "shot_chi2", "shot_residuals", "nuisance_count"):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name), name)
    np.testing.assert_array_equal(found.theory.vector, wanted.theory.vector)
    np.testing.assert_array_equal(found.states.time_s, wanted.states.time_s)
    np.testing.assert_array_equal(found.states.before.spin_b, wanted.states.before.spin_b)


def assert_same_ranking(found: Ranking, wanted: Ranking) -> None:
    for one, other in zip(found.candidates, wanted.candidates, strict=True):
        assert one.effect.name == other.effect.name
        assert (one.delta_chi2, one.p_familywise) == (other.delta_chi2, other.p_familywise)
        assert (one.carriers, one.carried_share) == (other.carriers, other.carried_share)
        np.testing.assert_array_equal(one.amplitudes, other.amplitudes)
        np.testing.assert_array_equal(one.sigmas, other.sigmas)
    np.testing.assert_array_equal(found.aliases, wanted.aliases)
    np.testing.assert_array_equal(found.imitated, wanted.imitated)
    np.testing.assert_array_equal(found.chance, wanted.chance)


def both_ways(data: PoseData, *effects: Effect) -> tuple[RobustFit, RobustFit]:
    """Return the same campaign judged in memory and from a file of uneven parts."""
    return robust_fit(data, effects), robust_fit(streamed(data, 3, 17, 200, 50), effects)


@pytest.mark.parametrize("shots", SIZES)
def test_fit_and_ranking_have_the_digits_of_those_in_memory(shots: int) -> None:
    wanted, found = both_ways(campaign(shots, 31, LAW, hidden=Hidden(slope=0.02)))
    assert isinstance(found.data, PoseStream)
    assert found.account == wanted.account
    assert_same_fit(found.fit, wanted.fit)
    assert_same_ranking(ranked(found), ranked(wanted))


@pytest.mark.parametrize("shots", [40, pytest.param(300, marks=pytest.mark.long)])
def test_bad_shots_frames_and_sigmas_are_judged_alike(shots: int) -> None:
    data = spoilt(campaign(shots, 33, LAW))
    wanted, found = both_ways(
        data.with_sigmas(
            np.full_like(data.position_sigma, 3e-5), np.full_like(data.rotation_sigma, 8e-3)
        )
    )
    assert 12 in wanted.account.rejected
    assert (8, 3) in wanted.account.frames
    assert wanted.account.noise[0] == pytest.approx(2 / 3, abs=0.02)
    assert found.account == wanted.account
    assert_same_fit(found.fit, wanted.fit)
    assert_same_ranking(ranked(found), ranked(wanted))


def test_effects_are_added_alike_those_of_the_noise_too(few_at_once: None) -> None:
    data = spoilt(jittered(campaign(40, 34, LAW, hidden=Hidden(slope=0.03))))
    wanted, found = both_ways(data, *chosen("restitution-viscoelastic"), JITTER)
    assert wanted.data.jitter_s == pytest.approx(JITTER_S, rel=0.2)
    assert found.data.jitter_s == wanted.data.jitter_s
    assert found.account == wanted.account
    assert_same_fit(found.fit, wanted.fit)


@pytest.mark.long
def test_a_contact_that_lasts_is_found_alike(few_at_once: None) -> None:
    wanted, found = both_ways(lasting(40, 42), LASTING)
    assert wanted.fit.theory.contact_law is not None
    assert_same_fit(found.fit, wanted.fit)


@pytest.mark.parametrize("shots", SIZES[:2])
def test_a_verdict_on_few_shots_has_the_digits_of_that_in_memory(shots: int) -> None:
    assert_same_verdict(campaign(shots, 36, LAW, hidden=Hidden(slope=0.05)))


@pytest.mark.long
@pytest.mark.parametrize("shots", SIZES[2:])
def test_a_verdict_has_the_digits_of_that_in_memory(shots: int) -> None:
    assert_same_verdict(spoilt(campaign(shots, 36, LAW, hidden=Hidden(slope=0.05))))


@pytest.mark.long
def test_a_verdict_on_contacts_that_last_has_the_digits_of_that_in_memory(
    few_at_once: None,
) -> None:
    assert_same_verdict(lasting(40, 43))


def assert_same_verdict(data: PoseData) -> None:
    stream = streamed(data, 3, 17, 200, 50)
    wanted, found = explain(data, CATALOGUE), explain(stream, CATALOGUE)
    assert document(stream, found) == document(data, wanted)
    assert_same_fit(found.fit, wanted.fit)
    assert_same_ranking(found.ranking, wanted.ranking)
    assert found.cells == wanted.cells


def document(data: CampaignData, verdict: Verdict) -> dict[str, object]:
    return verdict_document("one", data, verdict)


@pytest.fixture
def few_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have parts of sixteen shots, so that a short campaign has several."""
    monkeypatch.setattr(parts, "SHOTS_AT_ONCE", 16)


def test_parts_may_have_frames_of_their_own_number() -> None:
    data = campaign(40, 31, LAW)
    padded = PoseStream.of(part.padded(24 + k) for k, part in enumerate(in_parts(data, (9,))))
    assert_same_fit(fit_campaign(padded), fit_campaign(data.padded(28)))


def test_the_law_comes_out_within_its_errors() -> None:
    found = robust_fit(streamed(campaign(300, 32, LAW), 70)).fit
    sigma = np.sqrt(np.diag(found.covariance))
    assert np.abs((found.theory.vector - LAW) / sigma).max() < 4


def test_memory_does_not_grow_with_the_number_of_shots(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "SHOTS_AT_ONCE", 32)
    few, many = (peak(campaign(shots, 35, LAW)) for shots in (64, 320))
    # Poses of the further shots alone have 1.6 MB, the sums of their fit 1.2 MB.
    assert many < few + 3e5


def peak(data: PoseData) -> int:
    """Return the most memory that fit and ranking allocate, bytes."""
    stream = streamed(data, 32)
    del data
    tracemalloc.start()
    try:
        rank(stream, fit_campaign(stream), chosen("image-scale"))
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def ranked(found: RobustFit) -> Ranking:
    return rank(found.data, found.fit, (*EFFECTS, JITTER))


def lasting(shots: int, seed: int) -> PoseData:
    """Return a campaign of contacts that last."""
    forces = Forces(drag="increment", stiffness_ratio=0.6, damping_ratio=0.1)
    return posed(run_campaign(Nature(forces=forces), seed, shots=shots))


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
