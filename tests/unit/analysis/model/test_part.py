"""Beside `unexplained` stand only effects that explain something."""

from __future__ import annotations

import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.evidence import stage_of
from analysis.model.fitting.fit import fit_campaign
from analysis.model.verdict.part import LEAST_SAMPLINGS, LEAST_SHARE, what_explains
from analysis.model.verdict.selection import Verdict, explain
from tests.unit.analysis.model.chosen import chosen
from tests.unit.analysis.model.hard_spheres import Hidden, campaign
from tests.unit.analysis.model.proposals.hidden import campaign as of_the_world

HIDDEN = {"restitution-temperature": 0.008, "friction-spin": 0.2, "attraction": 20.0}
DEAR = pytest.param("attraction", marks=pytest.mark.long)


@pytest.fixture(scope="module", params=["restitution-temperature", "friction-spin", DEAR])
def verdict(request: pytest.FixtureRequest) -> Verdict:
    return explain(of_the_world({request.param: HIDDEN[request.param]}, 3), CATALOGUE)


def test_without_any_named_effect_shots_left_out_are_foretold_worse(verdict: Verdict) -> None:
    assert verdict.verdict == "unexplained"
    last, removable = verdict.path[-1], verdict.path[0].error.value - 1.0
    assert set(verdict.effects) == set(verdict.alias_sets)
    for active in verdict.fit.theory.active:
        data = verdict.cleaned.data
        rest = fit_campaign(data, last.fit.theory.without_effect(active.effect.name), last.fit)
        gain = stage_of(data, rest).error.value - last.error.value
        assert gain > LEAST_SAMPLINGS * last.error.sampling
        assert gain >= LEAST_SHARE * removable


def test_an_effect_that_explains_nothing_goes_and_one_that_does_stays() -> None:
    data = campaign(40, 91, hidden=Hidden(slope=0.02))
    base = fit_campaign(data)
    true, idle = chosen("restitution-viscoelastic", "camera-roll")
    with_true = fit_campaign(data, base.theory.with_effect(true), base)
    with_both = fit_campaign(data, with_true.theory.with_effect(idle), with_true)
    path = [stage_of(data, fit) for fit in (base, with_true, with_both)]
    assert what_explains(data, path)[-1].effects == (true.name,)
