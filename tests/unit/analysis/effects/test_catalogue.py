"""What every effect of the catalogue keeps to, whatever its physics."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import ContactLaw, Effect, ScatterEffect
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.predict.linear import linearise, whitened_residual
from analysis.model.predict.prediction import predict
from analysis.model.predict.theory import Theory
from analysis.model.rank.ranking import rank
from tests.unit.analysis.model.hard_spheres import campaign

EVERY = pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.name)
SHIFTS = [e for e in CATALOGUE if not isinstance(e, ScatterEffect | ContactLaw)]
"""What is noise of its own, or another law, has no derivative where it is off."""
EVERY_SHIFT = pytest.mark.parametrize("effect", SHIFTS, ids=lambda effect: effect.name)
WITH_VARIANTS = [(e, v) for e in SHIFTS for v in (e, *e.variants)]
EVERY_VARIANT = pytest.mark.parametrize(
    "effect",
    [v for _, v in WITH_VARIANTS],
    ids=[v.title.replace(" ", "-") for _, v in WITH_VARIANTS],
)


@cache
def clean() -> PoseData:
    return campaign(60, seed=11)


@cache
def base() -> Fit:
    return fit_campaign(clean())


def with_effect(effect: Effect, values: np.ndarray) -> Theory:
    theory = base().theory.with_effect(effect)
    return theory.at(np.concatenate([theory.vector[:3], values]))


def within_the_plausible_range(effect: Effect) -> np.ndarray:
    """Return a clear amplitude: half way from off to the end of the range that is further off."""
    far = [max(p.plausible, key=lambda end, off=p.off: abs(end - off)) for p in effect.parameters]
    return effect.off + 0.5 * (np.array(far) - effect.off)


def put_into_the_data(effect: Effect, values: np.ndarray) -> PoseData:
    """Return the clean campaign with what the effect does to the noiseless poses added."""
    data, states = clean(), base().states
    bare = predict(data, states, base().theory)
    changed = predict(data, states, with_effect(effect, values))
    turned = changed.rotation @ np.swapaxes(bare.rotation, -1, -2)
    return replace(
        data,
        position=data.position + changed.position - bare.position,
        rotation=turned @ data.rotation,
    )


def test_no_two_effects_share_a_name() -> None:
    names = [effect.name for effect in CATALOGUE]
    assert len(set(names)) == len(names)


@EVERY
def test_effects_it_is_confused_with_exist_and_are_others(effect: Effect) -> None:
    names = {other.name for other in CATALOGUE} - {effect.name}
    assert effect.confused_with
    assert set(effect.confused_with) <= names


@EVERY_VARIANT
def test_it_says_what_it_is(effect: Effect) -> None:
    assert all([effect.name, effect.title, effect.formula, effect.source, effect.gives_away])
    assert effect.parameters
    for parameter in effect.parameters:
        assert all([parameter.symbol, parameter.unit, parameter.meaning])
        assert parameter.step > 0


@EVERY
def test_variants_are_the_same_effect_with_the_same_parameters(effect: Effect) -> None:
    for variant in effect.variants:
        assert variant.name == effect.name
        assert [p.symbol for p in variant.parameters] == [p.symbol for p in effect.parameters]
        assert variant.title != effect.title


@EVERY_VARIANT
def test_off_lies_within_the_plausible_range_and_at_its_end_if_one_sided(effect: Effect) -> None:
    for parameter in effect.parameters:
        low, high = parameter.plausible
        assert low < high
        assert low <= parameter.off <= high
        if parameter.one_sided:
            assert low == parameter.off


@EVERY_VARIANT
def test_off_changes_nothing(effect: Effect) -> None:
    bare = predict(clean(), base().states, base().theory)
    off = predict(clean(), base().states, base().theory.with_effect(effect))
    assert np.array_equal(off.position, bare.position)
    assert np.array_equal(off.rotation, bare.rotation)


def differentiated(effect: Effect, factor: float) -> np.ndarray:
    """Return derivatives where the effect is off, by a step of `factor` times the stated one."""
    steps = tuple(replace(p, step=factor * p.step) for p in effect.parameters)
    theory = base().theory.with_effect(replace(effect, parameters=steps))
    return linearise(clean(), base().states, theory).by_theory[..., 3:]


@EVERY_VARIANT
def test_its_derivative_is_finite_and_does_not_hang_on_the_step(effect: Effect) -> None:
    full, half = differentiated(effect, 1.0), differentiated(effect, 0.5)
    assert np.isfinite(full).all()
    assert np.abs(full).max() > 0
    assert np.abs(full - half).max() < 1e-3 * np.abs(full).max()


@EVERY_SHIFT
def test_a_fit_brings_its_amplitude_back_and_chi_squared_down(effect: Effect) -> None:
    values = within_the_plausible_range(effect)
    data = put_into_the_data(effect, values)
    without = fit_campaign(data)
    found = fit_campaign(data, without.theory.with_effect(effect), without)
    sigma = np.sqrt(np.diag(found.covariance))[3:]
    assert found.converged
    assert np.abs((found.theory.vector[3:] - values) / sigma).max() < 3
    # Refitted, an effect may take a little of the noise with it, and leave none of its own.
    spare = len(values)
    assert base().chi2 - 12 * spare < found.chi2 < base().chi2 + 1


def test_no_effect_is_claimed_where_nothing_is_missing() -> None:
    ranking = rank(clean(), base(), CATALOGUE)
    assert min(candidate.p_familywise for candidate in ranking.candidates) > 0.01


def test_the_campaign_of_these_tests_has_nothing_missing() -> None:
    residual = whitened_residual(clean(), predict(clean(), base().states, base().theory))
    assert abs(base().chi2_per_dof - 1) < 4 * np.sqrt(2 / base().freedom)
    assert np.isclose((residual**2).sum(), base().chi2)
