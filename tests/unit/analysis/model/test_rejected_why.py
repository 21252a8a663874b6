"""Each shot that a fit leaves out is left out for a reason that it states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.effects.flight.drag import EFFECT as DRAG
from analysis.model.fitting.fit import fit_campaign
from analysis.model.fitting.robust_fit import FAR, on_shots_of, robust_fit
from tests.unit.analysis.model.hard_spheres import Hidden, campaign

MOVED_M = 3e-4
BAD = 7


def test_a_shot_too_far_from_the_rest_says_by_how_much() -> None:
    data = campaign(20, 91)
    scatter = np.random.default_rng(2).normal(0.0, MOVED_M, data.position[BAD].shape)
    position = data.position.copy()
    position[BAD] += scatter
    found = robust_fit(replace(data, position=position))
    number = int(data.shots[BAD])
    assert found.rejected == [number]
    before, after = FAR.split("{far:.3g}")
    why = found.rejected_why[number]
    assert why.startswith(before)
    assert why.endswith(after)
    # The scatter of the others is their stated error, which this one exceeds as often.
    exceeded = (MOVED_M / float(np.median(data.position_sigma[data.position_sigma > 0]))) ** 2
    assert 0.1 * exceeded < float(why.removeprefix(before).removesuffix(after)) < 2 * exceeded
    assert f"{number} ({why})" in " ".join(found.remarks())


def test_without_an_effect_the_shots_that_fit_with_it_alone_are_fitted_too_where_both_compare() -> (
    None
):
    data = campaign(20, 5, hidden=Hidden(drag=0.4))
    before, after = robust_fit(data), robust_fit(data, [DRAG])
    assert (len(before.rejected), after.rejected) == (2, [])
    same = on_shots_of(before, after)
    assert same.rejected == []
    assert same.fit.theory.active == ()
    # All shots are there, and are fitted no worse than from a start of their own.
    assert len(same.data.shots) == 20
    assert before.fit.chi2 < same.fit.chi2 <= fit_campaign(data).chi2
