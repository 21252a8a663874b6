"""No shots are chosen for effects that both fail, and what is missing is named instead."""

from functools import cache

import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.launch.fit import fit_launch
from analysis.launch.prediction import Limits
from analysis.model.data.poses import PoseData
from analysis.model.design.between import tell_apart
from analysis.model.design.candidates import grid
from analysis.model.design.misfit import MisfitError, require_one_that_fits, to_add_first
from analysis.model.fitting.fit import Fit, fit_campaign
from simulators.challenge.force_choice import Forces
from simulators.challenge.nature import Nature
from tests.unit.analysis.model.design.at_settings import drawn_settings, fired

LIMITS = Limits((12.0, 95.0), (0.0, 22.0))
KNOWN = {effect.name: effect for effect in CATALOGUE}
TORSION = KNOWN["torsional-friction"]


@cache
def lasting() -> tuple[PoseData, Fit]:
    """Return eight shots whose contacts last, fitted by the hard-sphere law."""
    data = fired(drawn_settings(8, 5), Nature(forces=Forces()), 5)
    return data, fit_campaign(data)


@pytest.mark.parametrize("other", ["none", "spin-decay", "wind", "buoyancy"])
def test_an_effect_that_takes_up_part_of_a_misfit_is_not_told_from_another(other: str) -> None:
    data, fit = lasting()
    settings = grid(LIMITS, alike=True)
    with pytest.raises(MisfitError, match="per degree of freedom"):
        tell_apart(data, fit, fit_launch(data, fit), (TORSION, KNOWN.get(other)), settings)


def test_the_law_that_is_missing_is_named_before_effects_that_make_up_for_it() -> None:
    assert to_add_first(*lasting(), CATALOGUE, {TORSION.name}) == "lasting-contact"


def test_an_effect_that_is_asked_for_is_not_its_own_remedy() -> None:
    assert to_add_first(*lasting(), [KNOWN["lasting-contact"]], {"lasting-contact"}) is None


def test_one_of_two_that_fits_is_enough() -> None:
    data, bad = lasting()
    good = fit_campaign(fired(drawn_settings(8, 5), Nature(), 5))
    require_one_that_fits(data, [bad, good])
    with pytest.raises(MisfitError):
        require_one_that_fits(data, [bad])
