"""Next shots against campaigns that were fired by physics of their own."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.errors import LaunchRefusedError
from analysis.launch.fit import fit_launch
from analysis.launch.prediction import Limits
from analysis.launch.result import LaunchFit
from analysis.model.data.poses import PoseData
from analysis.model.design.between import Repeated, Telling, best_fit, tell_apart
from analysis.model.design.candidates import Setting, candidates, grid
from analysis.model.design.document import shots_document, telling_document
from analysis.model.design.sharpen import sharpen
from analysis.model.design.undecided import fired_alike, next_after, used_limits
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.verdict.selection import explain
from simulators.challenge.nature import Nature
from tests.unit.analysis.model.design.at_settings import drawn_settings, fired

pytestmark = pytest.mark.long

SHOTS = 14
LIMITS = Limits((12.0, 95.0), (0.0, 22.0))
NATURE = Nature(viscosity=0.3)
KNOWN = {effect.name: effect for effect in CATALOGUE}
PAIR = (KNOWN["restitution-viscoelastic"], KNOWN["restitution-plastic"])


@cache
def campaign() -> tuple[PoseData, Fit, LaunchFit]:
    data = fired(drawn_settings(SHOTS, 5), NATURE, 5)
    fit = fit_campaign(data)
    return data, fit, fit_launch(data, fit)


@cache
def told(probability: float) -> Telling:
    return tell_apart(*campaign(), PAIR, grid(LIMITS, alike=True), probability=probability)


def places(shots: tuple[Repeated, ...]) -> np.ndarray:
    return np.array(
        [
            (one.setting.pressure_a_kpa, one.setting.offset_mm)
            for one in shots
            for _ in range(one.repeat)
        ]
    )


def test_the_shots_promise_what_was_asked_for_and_the_campaign_alone_does_not() -> None:
    found = told(0.9)
    assert found.enough
    assert found.without < 0.9 <= found.probability


def test_the_shots_lie_within_the_limits() -> None:
    pressure, offset = places(told(0.9).shots).T
    assert ((pressure >= 12.0) & (pressure <= 95.0)).all()
    assert ((offset >= 0.0) & (offset <= 22.0)).all()


def test_they_are_at_most_seventy_percent_of_an_even_design() -> None:
    found = told(0.9)
    assert found.even is not None
    assert found.count <= 0.7 * found.even


def test_more_certainty_takes_more_shots() -> None:
    assert told(0.98).count > told(0.9).count


def test_the_shots_set_the_effects_apart_as_far_as_is_promised() -> None:
    """Chi-squared between the two is a Gaussian of mean m and variance 4 m."""
    more = places(told(0.98).shots)
    ahead = []
    for seed in range(6):
        data = fired(drawn_settings(SHOTS, 100 + seed, more), NATURE, 100 + seed)
        base = fit_campaign(data)
        right, wrong = (best_fit(data, base, effect) for effect in PAIR)
        ahead.append(wrong.chi2 - right.chi2)
    promised = (2 * 2.0537) ** 2
    error = np.sqrt(4 * promised / len(ahead))
    assert np.mean(ahead) == pytest.approx(promised, abs=3 * error)


def test_an_effect_is_told_from_none_by_fewer_shots_the_larger_it_is() -> None:
    data, base, launch = campaign()
    seen = tell_apart(data, base, launch, (PAIR[0], None), grid(LIMITS, alike=True))
    assert seen.count == 0
    assert seen.probability > 0.99


def test_a_sharpened_parameter_is_as_sure_as_was_promised() -> None:
    data = fired(drawn_settings(SHOTS, 9), Nature(), 9)
    fit = fit_campaign(data)
    found = sharpen(data, fit, fit_launch(data, fit), "mu", grid(LIMITS, alike=True))
    assert found.enough
    assert found.reached <= found.target == pytest.approx(found.present / 2)
    together = fired(drawn_settings(SHOTS, 9, places(found.shots)), Nature(), 9)
    reached = fit_campaign(together).parameters()["mu"].sigma
    assert reached == pytest.approx(found.reached, rel=0.15)


def test_settings_are_forgotten_where_the_spheres_would_miss() -> None:
    data, fit, launch = campaign()
    meeting, missing = Setting(50.0, 50.0, 6.0), Setting(50.0, 50.0, 40.0)
    assert candidates(data, fit, launch, [missing, meeting]).settings == (meeting,)


def test_no_setting_at_all_is_refused() -> None:
    data, fit, launch = campaign()
    with pytest.raises(LaunchRefusedError, match="no setting"):
        candidates(data, fit, launch, [Setting(50.0, 50.0, 40.0)])


def test_a_verdict_without_doubt_asks_for_nothing() -> None:
    data = fired(drawn_settings(SHOTS, 7), Nature(), 7)
    effects = [KNOWN["pixel-aspect"]]
    verdict = explain(data, effects)
    assert verdict.verdict == "none"
    assert next_after(verdict, effects) is None


def test_an_alias_asks_for_shots_in_the_range_that_was_used() -> None:
    data = fired(drawn_settings(SHOTS, 6), NATURE, 6)
    verdict = explain(data, PAIR)
    assert verdict.verdict == "alias"
    found = next_after(verdict, PAIR)
    assert found is not None
    assert found.count > 0
    low, high = used_limits(data).pressure_kpa
    pressure = places(found.shots)[:, 0]
    assert ((pressure >= low) & (pressure <= high)).all()


def test_an_alias_without_settings_asks_for_nothing() -> None:
    data = fired(drawn_settings(SHOTS, 6), NATURE, 6)
    data = replace(data, covariates={"order": data.covariates["order"]})
    verdict = explain(data, PAIR)
    assert verdict.verdict == "alias"
    assert next_after(verdict, PAIR) is None


def test_pushers_of_different_pressures_are_noticed() -> None:
    data = campaign()[0]
    assert fired_alike(data)
    other = {**data.covariates, "pressure_b_kpa": data.covariates["pressure_b_kpa"] + 1.0}
    assert not fired_alike(replace(data, covariates=other))


def test_the_document_counts_the_shots_that_it_lists() -> None:
    found = told(0.9)
    document = telling_document(found)
    assert document["between"] == ["restitution-viscoelastic", "restitution-plastic"]
    assert document["shots"] == sum(one["repeat"] for one in document["next_shots"])
    assert shots_document(found.shots) == document["next_shots"]


@pytest.mark.parametrize("alike", [True, False])
def test_the_grid_reaches_the_ends_of_the_limits(alike: bool) -> None:
    settings = grid(LIMITS, alike=alike)
    assert {s.pressure_a_kpa for s in settings} >= {12.0, 95.0}
    assert {s.offset_mm for s in settings} >= {0.0, 22.0}
    assert all(s.pressure_a_kpa == s.pressure_b_kpa for s in settings) == alike
