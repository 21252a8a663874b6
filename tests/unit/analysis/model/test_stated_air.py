"""Air that is not as stated is found by a test of its own, at the family's level."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from analysis.effects.camera.image_scale import EFFECT as IMAGE_SCALE
from analysis.effects.catalogue import CATALOGUE
from analysis.effects.flight.drag import EFFECT as DRAG
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.rank.candidate import STATED_WEIGHT, weight_of
from analysis.model.rank.ranking import rank, smallest_by_chance
from analysis.model.rank.score_test import Block
from analysis.model.verdict.selection import Verdict, explain
from benchmarks.discovery.lasting import HIDDEN, PLAIN, lasting_campaign
from tests.unit.analysis.model.hard_spheres import RADIUS, Hidden, campaign

SLOWING = 3 * 1.2 / (8 * RADIUS * 1150.0)
"""rho A / (2 m), 1/m, for each unit of the drag coefficient."""


def in_air(coefficient: float, seed: int) -> PoseData:
    """Return hard spheres in air of which 0.42 +- 0.2 is stated."""
    data = campaign(60, seed, hidden=Hidden(drag=coefficient * SLOWING))
    return replace(data, drag_coefficient=0.42)


def test_a_weighted_look_costs_the_family_what_it_counts_for() -> None:
    """Thirty looks and one of weight ten, all independent: 1 - (1 - t)^30 (1 - 10 t) = level."""
    blocks = [Block(np.array([k]), np.ones((1, 1)), one_sided=False) for k in range(31)]
    weights = [1.0] * 30 + [STATED_WEIGHT]
    smallest = np.concatenate(
        [
            smallest_by_chance(np.eye(31), blocks, weights, np.random.default_rng(seed))
            for seed in range(10)
        ]
    )
    for level in (0.03, 0.1):
        t = float(np.quantile(smallest, level))
        expected = 1 - (1 - t) ** 30 * (1 - STATED_WEIGHT * t)
        assert expected == pytest.approx(level, abs=4 * np.sqrt(level / len(smallest)))


def test_an_effect_that_hardly_shows_makes_no_other_less_sure() -> None:
    """Rounding of the largest column is no noise of the smallest: thirty looks cost thirty."""
    rng = np.random.default_rng(3)
    size = 10.0 ** np.linspace(-5.0, 5.0, 30)
    draws = rng.standard_normal((200, 30))
    matrix = draws.T @ draws / 200 * size[:, None] * size
    blocks = [
        Block(np.array([k]), np.array([[matrix[k, k] ** -0.5]]), one_sided=False) for k in range(30)
    ]
    smallest = smallest_by_chance(matrix, blocks, [1.0] * 30, np.random.default_rng(4))
    # No more than thirty independent looks make of it, and with some correlation hardly less.
    t = float(np.quantile(smallest, 0.1))
    assert 1 - (1 - t) ** 30 == pytest.approx(0.1, abs=0.04)
    assert smallest.min() > 1e-7


def test_only_an_effect_of_the_flight_that_is_stated_is_asked_for_by_itself() -> None:
    assert weight_of(DRAG, stated=True) == STATED_WEIGHT
    assert weight_of(DRAG, stated=False) == 1.0
    assert weight_of(IMAGE_SCALE, stated=True) == 1.0


def test_air_as_stated_is_rarely_a_finding() -> None:
    effects = [effect for effect in CATALOGUE if effect.name in {"drag", "wind", "frame-rate"}]
    found = []
    for seed in range(100, 120):
        data = in_air(0.42, seed)
        ranking = rank(data, fit_campaign(data), effects)
        found += [c for c in ranking.candidates if c.effect.name == "drag"]
    assert {c.weight for c in found} == {STATED_WEIGHT}
    # Each is below 0.05 with a chance of as much: five or more of twenty with 0.003.
    assert sum(c.p_familywise < 0.05 for c in found) <= 4


@cache
def verdict(world: str) -> Verdict:
    return explain(lasting_campaign(HIDDEN.get(world, PLAIN), 902, 120), CATALOGUE)


@pytest.mark.long
def test_a_drag_three_times_as_large_is_named_on_top_of_contacts_that_last() -> None:
    found = verdict("drag")
    assert (found.verdict, {*found.effects}) == ("effect", {"lasting-contact", "drag"})
    value = found.fit.parameters()["drag.Cd"]
    assert value.value == pytest.approx(1.2, abs=4 * value.sigma)
    assert value.sigma < 0.1


def test_a_drag_as_stated_is_not_named() -> None:
    assert verdict("plain").effects == ("lasting-contact",)
