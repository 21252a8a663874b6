"""Ranking the effects of the launch on the simulated rig."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from analysis.effects.catalogue import LAUNCH_CATALOGUE
from analysis.launch.fit import fit_touches
from analysis.launch.ranking import LaunchRanking, rank_launch
from simulators.world.description import Tube
from tests.unit.analysis.launch.fired import NONE, TUBE, Faults, fired

FAULTS = {
    "pressure-hysteresis": (Faults(hysteresis=0.01), 0.01),
    "pressure-leak": (Faults(leak=1e-3), 1e-3),
    "launch-delay": (Faults(delay_s=4e-4), 4e-4),
    "tube-spin": (Faults(rolling=0.4), 0.4),
    "slide-backlash": (Faults(backlash_m=2e-4), 2e-4),
}


@cache
def ranked(faults: Faults = NONE, seed: int = 11, tube: Tube = TUBE) -> LaunchRanking:
    touches, settings = fired(120, seed, faults, tube=tube)
    return rank_launch(fit_touches(touches, settings), LAUNCH_CATALOGUE)


@pytest.mark.parametrize("name", FAULTS)
def test_what_is_missing_comes_first_with_its_amplitude(name: str) -> None:
    faults, true = FAULTS[name]
    first = ranked(faults).candidates[0]
    assert first.effect.name == name
    assert not first.fitted
    assert first.p_familywise < 0.001
    assert abs(first.amplitudes[0] - true) < 4 * first.sigmas[0]
    assert first.score**2 == pytest.approx(first.delta_chi2)


@pytest.mark.parametrize("name", FAULTS)
def test_the_promise_is_kept_by_a_refit(name: str) -> None:
    """Held at the scatter of the fit without, the fall is what the refit brings."""
    faults, _ = FAULTS[name]
    touches, settings = fired(120, 11, faults)
    base = fit_touches(touches, settings)
    candidate = ranked(faults).candidates[0]
    effects = [active.effect for active in base.theory.active]
    refit = fit_touches(touches, settings, (*effects, candidate.effect))
    before, _ = base.compared.whitened(base.scatter)
    after, _ = refit.compared.whitened(base.scatter)
    assert (before**2).sum() - (after**2).sum() == pytest.approx(candidate.delta_chi2, rel=0.15)


def test_nothing_is_claimed_where_only_friction_is_there() -> None:
    smallest = [
        min(one.p_familywise for one in ranked(seed=seed).candidates if not one.fitted)
        for seed in range(11, 19)
    ]
    assert min(smallest) > 0.01
    assert max(smallest) > 0.3


def test_friction_has_its_score_though_it_is_in_the_fit() -> None:
    friction = ranked().candidates[-1]
    assert (friction.effect.name, friction.fitted) == ("pressure-friction", True)
    assert friction.p_familywise < 0.001
    assert friction.amplitudes == pytest.approx([5.762, 5.762], abs=0.4)


def test_a_pusher_without_friction_makes_no_score_of_it() -> None:
    smooth = ranked(tube=replace(TUBE, friction_n=0.0))
    friction = next(one for one in smooth.candidates if one.fitted)
    assert friction.p_value > 0.01
    assert (np.abs(friction.amplitudes) < 4 * friction.sigmas).all()


def test_taking_friction_out_costs_what_its_score_says() -> None:
    smooth = replace(TUBE, friction_n=0.02)
    touches, settings = fired(120, 12, tube=smooth)
    with_it = fit_touches(touches, settings)
    score = next(one for one in rank_launch(with_it, LAUNCH_CATALOGUE).candidates if one.fitted)
    without = fit_touches(touches, settings, ())
    before, _ = without.compared.whitened(with_it.scatter)
    after, _ = with_it.compared.whitened(with_it.scatter)
    assert (before**2).sum() - (after**2).sum() == pytest.approx(score.delta_chi2, rel=0.2)


def test_what_the_settings_hold_nothing_on_cannot_be_seen() -> None:
    touches, settings = fired(60, 13)
    settings = replace(settings, slide_step=np.zeros(60), waited_s=np.zeros(60))
    ranking = rank_launch(fit_touches(touches, settings), LAUNCH_CATALOGUE)
    unseen = {one.effect.name for one in ranking.candidates if not one.seen}
    assert unseen == {"slide-backlash", "pressure-leak"}
    assert [one.seen for one in ranking.candidates] == [True] * 4 + [False] * 2


def test_effects_that_a_schedule_runs_together_are_aliases() -> None:
    """Waits that follow the direction of the last step make a leak of hysteresis."""
    touches, settings = fired(120, 14)
    step = settings.pressure_step[:, 0]
    both = np.stack([step, step], axis=1)
    together = replace(settings, pressure_step=both, waited_s=30.0 - 10.0 * step)
    names = ("pressure-leak", "pressure-hysteresis")

    def alias(ranking: LaunchRanking) -> float:
        order = [one.effect.name for one in ranking.candidates]
        return float(ranking.aliases[order.index(names[0]), order.index(names[1])])

    apart = rank_launch(fit_touches(touches, settings), LAUNCH_CATALOGUE)
    joined = rank_launch(fit_touches(touches, together), LAUNCH_CATALOGUE)
    assert alias(apart) < 0.3
    assert alias(joined) > 0.9
    assert np.diag(joined.aliases) == pytest.approx(np.ones(6))


def test_an_amplitude_no_rig_has_is_not_plausible() -> None:
    first = ranked(Faults(hysteresis=0.06)).candidates[0]
    assert first.effect.name == "pressure-hysteresis"
    assert not first.plausible
    assert ranked(Faults(hysteresis=0.01)).candidates[0].plausible


def test_an_effect_that_has_one_sign_is_not_scored_by_the_other() -> None:
    backwards = next(
        one for one in ranked(Faults(rolling=-0.4)).candidates if one.effect.name == "tube-spin"
    )
    assert backwards.amplitudes[0] == pytest.approx(-0.4, abs=0.1)
    assert (backwards.delta_chi2, backwards.p_value) == (0.0, 1.0)
    assert not backwards.plausible
