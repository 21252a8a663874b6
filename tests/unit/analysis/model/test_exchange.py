"""Accepted effects are weighed again beside each other; what only stood in for another goes."""

from __future__ import annotations

from functools import cache

from analysis.model.data.evidence import Stage, stage_of
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.verdict.exchange import exchanged, fits_without
from simulators.challenge.nature import Nature
from tests.unit.analysis.model.chosen import chosen
from tests.unit.analysis.model.design.at_settings import drawn_settings, fired

SHOTS, SEED = 60, 31
EFFECTS = chosen(
    *("mass-mismatch", "radius-mismatch", "image-scale", "restitution-plastic"),
    *("restitution-viscoelastic", "friction-drift"),
)


@cache
def unequal() -> PoseData:
    """Return shots of spheres of unequal mass that restitute less the faster they meet."""
    nature = Nature(mass_difference=0.0025, restitution_power=0.015)
    return fired(drawn_settings(SHOTS, SEED), nature, SEED)


def standing(*names: str) -> Stage:
    fit = fit_campaign(unequal())
    for effect in chosen(*names):
        fit = fit_campaign(unequal(), fit.theory.with_effect(effect), fit)
    return stage_of(unequal(), fit)


def less(stage: Stage) -> dict[str, Fit]:
    return fits_without(unequal(), stage.fit)


def test_what_was_accepted_in_the_place_of_another_is_exchanged_for_it() -> None:
    wrong = standing("radius-mismatch", "restitution-plastic")
    right, alike = exchanged(unequal(), wrong, EFFECTS, {}, less(wrong))
    assert "mass-mismatch" in right.effects
    assert "radius-mismatch" not in right.effects
    assert right.error.value < wrong.error.value
    assert set(alike) >= set(right.effects)


def test_what_is_there_stays_and_keeps_what_looks_like_it() -> None:
    right = standing("mass-mismatch", "restitution-plastic")
    after, alike = exchanged(unequal(), right, EFFECTS, {}, less(right))
    assert "mass-mismatch" in after.effects
    assert "friction-drift" not in {name for names in alike.values() for name in names}
    falling = next(name for name in after.effects if name.startswith("restitution"))
    assert {"restitution-plastic", "restitution-viscoelastic"} == set(alike[falling])
