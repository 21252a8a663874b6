"""The ranking names what was put into the data, with its size, and is quiet when nothing was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.model.fitting.fit import fit_campaign
from analysis.model.rank.ranking import rank
from analysis.model.verdict.documents import alike
from tests.unit.analysis.model.chosen import EFFECTS, chosen
from tests.unit.analysis.model.hard_spheres import Hidden, campaign


def test_stretched_pictures_are_named_and_measured() -> None:
    data = campaign(40, 2)
    stretched = replace(data, position=1.004 * data.position)
    ranking = rank(stretched, fit_campaign(stretched), EFFECTS)
    first = ranking.candidates[0]
    assert first.effect.name == "image-scale"
    assert first.amplitudes[0] == pytest.approx(0.004, abs=4 * first.sigmas[0] + 1e-4)
    assert first.p_familywise < 0.001
    assert first.plausible


def test_a_slow_clock_is_named_and_measured() -> None:
    data = campaign(60, 4)
    slow = replace(data, times_s=data.times_s / 1.01)
    names = [c for c in rank(slow, fit_campaign(slow), EFFECTS).candidates if c.seen]
    clock = next(c for c in names if c.effect.name == "frame-rate")
    assert clock.amplitudes[0] == pytest.approx(0.01, abs=4 * clock.sigmas[0])
    assert not clock.plausible


def test_restitution_that_falls_with_speed_is_named_and_measured() -> None:
    data = campaign(40, 6, hidden=Hidden(slope=0.03))
    first = rank(data, fit_campaign(data), EFFECTS).candidates[0]
    assert first.effect.name == "restitution-viscoelastic"
    assert first.amplitudes[0] == pytest.approx(0.03, abs=4 * first.sigmas[0] + 1e-3)
    assert first.plausible


def test_drag_is_measured() -> None:
    mass, area = 1150 * np.pi / 6 * 0.0254**3, np.pi * 0.0127**2
    data = campaign(40, 8, hidden=Hidden(drag=8.0 * 1.2 * area / (2 * mass)))
    ranking = rank(data, fit_campaign(data), EFFECTS)
    drag = next(c for c in ranking.candidates if c.effect.name == "drag")
    assert drag.amplitudes[0] == pytest.approx(8.0, abs=4 * drag.sigmas[0])
    assert drag.p_familywise < 0.01
    assert not drag.plausible


@pytest.mark.long
def test_nothing_missing_is_rarely_called_something() -> None:
    smallest = []
    for seed in range(20):
        data = campaign(15, 100 + seed)
        ranking = rank(data, fit_campaign(data), EFFECTS)
        smallest.append(min(c.p_familywise for c in ranking.candidates))
    # Twenty uniform numbers: below 0.05 at most four times in 99.7 per cent of all cases.
    assert sum(p < 0.05 for p in smallest) <= 4
    assert max(smallest) > 0.3


def test_without_orientations_what_only_spin_can_show_is_not_scored() -> None:
    data = campaign(20, 9)
    blind = replace(data, rotation_sigma=np.full_like(data.rotation_sigma, np.inf))
    ranking = rank(blind, fit_campaign(blind), EFFECTS)
    assert all(np.isfinite(c.delta_chi2) for c in ranking.candidates)
    assert {type(c.seen) for c in ranking.candidates} == {bool}


def test_when_every_effect_is_in_the_fit_there_is_nothing_to_rank() -> None:
    data = campaign(6, 9)
    [scale] = chosen("image-scale")
    fit = fit_campaign(data)
    ranking = rank(data, fit_campaign(data, fit.theory.with_effect(scale), fit), [scale])
    assert ranking.candidates == ()
    assert ranking.aliases.shape == (0, 0)


def test_effects_that_leave_unlike_errors_are_not_called_alike() -> None:
    data = campaign(40, 6, hidden=Hidden(slope=0.03))
    ranking = rank(data, fit_campaign(data), CATALOGUE)
    like = alike(ranking, 0)
    assert "restitution-plastic" in like
    place = next(
        k for k, one in enumerate(ranking.candidates) if one.effect.name == "restitution-plastic"
    )
    strong = replace(ranking, freedom=1000, noise_scale=2.0)

    def named(fall: float, rival: float) -> bool:
        given = [replace(one, delta_chi2=fall) for one in strong.candidates]
        given[place] = replace(given[place], delta_chi2=rival)
        return "restitution-plastic" in alike(replace(strong, candidates=tuple(given)), 0)

    # A tenth of the noise of 1000 degrees of freedom is 25 where the noise is found twice as large.
    assert named(700.0, 680.0)
    assert not named(700.0, 670.0)
    # A large promise is not exact to that.
    assert named(70_000.0, 69_000.0)
