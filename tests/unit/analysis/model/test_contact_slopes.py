"""Slopes of contacts that last, held against differences of its own outcome."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.collision.operator import Body
from analysis.effects.contact.lasting_contact import EFFECT as LASTING
from analysis.effects.contact.restitution_obliquity import EFFECT as OBLIQUITY
from analysis.effects.effect import Effect
from analysis.model.fitting.fit import START
from analysis.model.predict.contact import differentiated_contact, outcome_of_slopes
from analysis.model.predict.start import first_states
from analysis.model.predict.state import MOTION, SIZE, TILT
from analysis.model.predict.theory import Theory
from tests.unit.analysis.model.hard_spheres import campaign

NYLON = Body.sphere(0.0254, 1150.0, 0.4)
STEPS = (TILT, 1e-5), (MOTION, 1e-4)
SLOPES_WITHIN = 0.005


@pytest.mark.parametrize("other", [NYLON, Body.sphere(0.0127, 2500.0, 0.4)], ids=["like", "unlike"])
@pytest.mark.parametrize("beside", [[], [OBLIQUITY]], ids=["alone", "beside an effect"])
def test_slopes_of_a_contact_that_lasts_are_those_of_differences(
    other: Body, beside: list[Effect]
) -> None:
    data = replace(campaign(12, 3), bodies=(NYLON, other))
    theory = Theory(START).with_effect(LASTING, np.array([8e-5, 0.8, 0.1]))
    for effect in beside:
        theory = theory.with_effect(effect)
    states = first_states(data)
    slopes = differentiated_contact(data, states, theory).by_state
    column = 0
    for numbers, size in STEPS:
        for k in range(numbers.start, numbers.stop):
            step = np.zeros((data.count, SIZE))
            step[:, k] = size
            ahead, back = (outcome_of_slopes(data, states.moved(s * step), theory) for s in (1, -1))
            expected = (ahead - back) / (2 * size)
            scale = np.abs(expected).max(axis=0).clip(min=1e-9)
            # Where sticking turns to sliding within the step there is no slope.
            off = np.abs(slopes[..., column] - expected) / scale
            assert np.median(off, axis=0).max() < SLOPES_WITHIN / 2
            assert (off < SLOPES_WITHIN).mean() > 0.95
            column += 1
    assert column == slopes.shape[2]
