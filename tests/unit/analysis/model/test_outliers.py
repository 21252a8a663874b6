"""Wild frames and wild shots go and are listed; strange shots in number are physics and stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.model.data.inside import without_contact_frames
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import START, fit_campaign
from analysis.model.fitting.outliers import Cleaned, bad_shots, clean
from analysis.model.predict.theory import Theory
from benchmarks.discovery.campaigns import campaign as simulated
from tests.unit.analysis.model.hard_spheres import campaign

SHOTS = 30


def with_wild_frame(data: PoseData, shot: int, frame: int) -> PoseData:
    position = data.position.copy()
    position[shot, frame, 1] += [0.0, 1.5e-3, 0.0]
    return replace(data, position=position)


def with_wild_shot(data: PoseData, shot: int) -> PoseData:
    """Return the data with sphere a followed in a bend of 0.4 mm."""
    position = data.position.copy()
    position[shot, :, 0, 1] += 4e-4 * np.sin(np.arange(position.shape[1]) / 2)
    return replace(data, position=position)


def lost(cleaned: Cleaned) -> list[int]:
    return (np.flatnonzero(~cleaned.kept) + 1).tolist()


def test_a_wild_frame_goes_and_its_shot_stays() -> None:
    cleaned = clean(with_wild_frame(campaign(SHOTS, 51), 7, 3))
    assert cleaned.frames == ((8, 3),)
    assert lost(cleaned) == []
    assert not cleaned.data.measured[7, 3].any()
    assert cleaned.data.measured.sum() == SHOTS * 24 * 12 - 12


def test_two_wild_frames_of_one_shot_both_go() -> None:
    data = with_wild_frame(with_wild_frame(campaign(SHOTS, 51), 7, 3), 7, 19)
    position = data.position.copy()
    position[7, 19, 1, 1] += 4e-3
    cleaned = clean(replace(data, position=position))
    assert sorted(cleaned.frames) == [(8, 3), (8, 19)]
    assert lost(cleaned) == []


def test_a_wild_shot_goes() -> None:
    cleaned = clean(with_wild_shot(campaign(SHOTS, 52), 11))
    assert lost(cleaned) == [12]
    assert cleaned.data.shots.tolist() == [n for n in range(1, SHOTS + 1) if n != 12]


def test_a_wild_frame_and_a_wild_shot_are_told_apart() -> None:
    data = with_wild_frame(with_wild_shot(campaign(SHOTS, 53), 2), 20, 15)
    cleaned = clean(data)
    assert lost(cleaned) == [3]
    assert cleaned.frames == ((21, 15),)


def test_what_is_left_gives_the_law_of_a_campaign_that_was_never_spoilt() -> None:
    true = fit_campaign(campaign(SHOTS, 54)).parameters()
    spoilt = with_wild_frame(with_wild_shot(campaign(SHOTS, 54), 2), 20, 15)
    found = clean(spoilt).fit.parameters()
    for name, quantity in true.items():
        assert found[name].value == pytest.approx(quantity.value, abs=1.5 * quantity.sigma)


@pytest.mark.parametrize(("some", "every", "e"), [(1, 5, 0.725), (3, 10, 0.70)])
def test_strange_shots_in_number_are_physics_and_stay(some: int, every: int, e: float) -> None:
    usual, strange = campaign(SHOTS, 55), campaign(SHOTS, 55, (e, 0.08, 0.5))
    odd = np.arange(SHOTS) % every < some
    position = np.where(odd[:, None, None, None], strange.position, usual.position)
    cleaned = clean(replace(usual, position=position))
    assert lost(cleaned) == []
    assert cleaned.frames == ()
    assert cleaned.fit.chi2_per_dof > 1.1


def test_shots_dropped_before_count_when_it_is_asked_whether_it_is_physics() -> None:
    data = campaign(SHOTS, 52)
    for shot in (3, 11, 19):
        data = with_wild_shot(data, shot)
    position = data.position.copy()
    position[24, :, 0, 1] += 9e-5 * np.sin(np.arange(24) / 2)
    fit = fit_campaign(replace(data, position=position))
    assert np.flatnonzero(bad_shots(fit)).tolist() == [3, 11, 19, 24]
    assert np.flatnonzero(bad_shots(fit, gone=10)).tolist() == [3, 11, 19]


@pytest.mark.long
def test_clean_campaigns_lose_no_more_than_the_stated_share() -> None:
    # One in 200 loses a shot: of 12 campaigns two or more in 0.2 per cent.
    cleaned = [clean(campaign(12, 500 + seed)) for seed in range(12)]
    assert sum(not c.kept.all() for c in cleaned) <= 1
    assert sum(len(c.frames) for c in cleaned) <= 1


def test_three_shots_are_too_few_to_call_one_of_them_bad() -> None:
    cleaned = clean(with_wild_shot(campaign(3, 56), 1))
    assert lost(cleaned) == []


def test_a_shot_that_began_on_the_wrong_side_of_the_corner_is_brought_back() -> None:
    # Between rolling and sliding one of these shots stays where the first guess of the law put it.
    data = without_contact_frames(simulated({"pixel-aspect": 8.22e-4}, 826, 30))
    assert clean(data).fit.chi2 < fit_campaign(data, Theory(START)).chi2 - 30
