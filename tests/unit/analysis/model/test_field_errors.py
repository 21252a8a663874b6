"""Errors that change with the place in the field name no effect, and widen what is fitted.

The fields are sums of random waves, drawn here.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import beside_field, fit_campaign
from analysis.model.fitting.slow_errors.field import Field, field_errors
from analysis.model.fitting.slow_errors.sizes import with_measured_slow_errors
from analysis.model.rank.ranking import rank
from analysis.model.structure.far_off import is_far_off
from analysis.model.structure.lackoffit import lack_of_fit
from analysis.setup import NO_SLOW_ERRORS, SlowErrors
from tests.unit.analysis.model.hard_spheres import Hidden, campaign

Floats = NDArray[np.float64]

PLACE_M, TURN_RAD, COURSE_M, WAVES = 2e-6, 2e-4, 0.008, 40
SLOW = SlowErrors(position_m=1e-9, rotation_rad=1e-7, shared_m=PLACE_M)
LAW = (0.74, 0.08, 0.5)
SEEDS = range(100, 103)


def waves(places: Floats, rng: np.random.Generator) -> Floats:
    """Return three random functions of place, of size 1 and correlated over COURSE_M."""
    vectors = rng.normal(0.0, 1.0 / COURSE_M, (3, WAVES, 3))
    phases = rng.uniform(0.0, 2.0 * np.pi, (3, WAVES))
    along = np.einsum("...k,cwk->...cw", places, vectors) + phases
    return np.asarray(np.sqrt(2.0 / WAVES) * np.cos(along).sum(axis=-1))


def seen_by_place(
    seed: int, shots: int = 32, hidden: Hidden | None = None, *, size: float = 1.0
) -> PoseData:
    """Return hard spheres of which places and orientations are seen off by where they are."""
    data = campaign(
        shots,
        seed,
        LAW,
        hidden=Hidden() if hidden is None else hidden,
        position_sigma=2e-6,
        rotation_sigma=2e-4,
    )
    rng = np.random.default_rng([seed, 1])
    position, rotation = data.position.copy(), data.rotation.copy()
    for i in (0, 1):
        places = data.position[:, :, i]
        position[:, :, i] += size * PLACE_M * waves(places, rng)
        turns = Rotation.from_rotvec((size * TURN_RAD * waves(places, rng)).reshape(-1, 3))
        rotation[:, :, i] = turns.as_matrix().reshape(rotation[:, :, i].shape) @ rotation[:, :, i]
    return replace(data, position=position, rotation=rotation, slow=SLOW)


def unstated(data: PoseData) -> PoseData:
    return replace(data, slow=NO_SLOW_ERRORS)


def named(data: PoseData) -> list[str]:
    """Return the effects that stand out beside the base model."""
    ranking = rank(data, fit_campaign(data), CATALOGUE)
    return [c.effect.name for c in ranking.candidates if c.seen and c.p_familywise < 0.002]


@cache
def pulls(*, stated: bool) -> Floats:
    """Return errors of e and mu over the stated ones in many campaigns, shape (K, 2)."""
    found = []
    for seed in range(40, 58):
        data = seen_by_place(seed)
        data = data if stated else unstated(data)
        fitted = beside_field(data, fit_campaign(data)).parameters()
        found.append(
            [
                (fitted[n].value - true) / fitted[n].sigma
                for n, true in zip(("e", "mu"), LAW, strict=False)
            ]
        )
    return np.array(found)


def test_functions_have_the_fields_correlation_between_the_places_it_was_made_from() -> None:
    rng = np.random.default_rng(1)
    points, places = (rng.uniform(-1, 1, (n, 3)) * [0.03, 0.03, 0.002] for n in (400, 60))
    functions = Field.over(points, 0.015).functions(places)
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    correlation = np.exp(-((apart / 0.015) ** 2) / 2)
    assert np.abs(functions @ functions.T - correlation).max() < 0.12
    assert np.abs(functions @ functions.T - correlation).mean() < 0.02


def test_without_slow_errors_there_is_no_field() -> None:
    assert field_errors(unstated(seen_by_place(1))).count == 0
    alike = replace(seen_by_place(1), slow=replace(SLOW, varying=0.0))
    assert field_errors(with_measured_slow_errors(alike)).count == 0
    assert field_errors(seen_by_place(1)).count > 0


def test_what_lies_in_the_field_is_taken_for_no_effect() -> None:
    data = [seen_by_place(seed) for seed in SEEDS]
    assert sum(bool(named(unstated(one))) for one in data) == 3
    assert sum(bool(named(one)) for one in data) == 0


def test_what_lies_in_the_field_leaves_no_structure() -> None:
    data = [seen_by_place(seed) for seed in SEEDS]
    left = [lack_of_fit(one, fit_campaign(one))[0].p_holm for one in data]
    bare = [lack_of_fit(unstated(one), fit_campaign(unstated(one)))[0].p_holm for one in data]
    assert sum(p < 1e-3 for p in bare) == 3
    assert sum(p < 1e-3 for p in left) == 0


def test_a_force_beyond_the_field_is_still_named() -> None:
    assert "drag" in named(seen_by_place(3, hidden=Hidden(drag=0.3)))


@pytest.mark.long
def test_fitted_parameters_are_as_far_off_as_the_field_lets_them_be() -> None:
    assert (np.sqrt((pulls(stated=False) ** 2).mean(axis=0)) > 1.4).all()
    assert np.sqrt((pulls(stated=True) ** 2).mean(axis=0)) == pytest.approx(1.0, abs=0.45)


@pytest.mark.parametrize("size", [0.5, 1.0, 2.0])
def test_the_field_is_as_large_as_flights_show(size: float) -> None:
    found = with_measured_slow_errors(seen_by_place(7, size=size)).slow
    assert found.varying == pytest.approx(size, rel=0.4)


def test_what_is_alike_over_the_field_makes_it_small() -> None:
    data = seen_by_place(7, size=0.0)
    shifted = data.position + np.array([[[[0.0, 2e-6, -3e-6], [1e-6, 0.0, 2e-6]]]])
    found = with_measured_slow_errors(replace(data, position=shifted)).slow
    assert found.varying < 0.5


def test_a_field_leaves_slow_errors_of_flights_as_they_are() -> None:
    slow = SlowErrors(position_m=1e-6, rotation_rad=1e-4, shared_m=PLACE_M)
    found = with_measured_slow_errors(replace(seen_by_place(7), slow=slow)).slow
    assert found.position_m < 0.5e-6


def test_a_chi_squared_that_the_field_makes_is_not_rare() -> None:
    for seed in SEEDS:
        data = seen_by_place(seed)
        stated, bare = beside_field(data, fit_campaign(data)), fit_campaign(unstated(data))
        assert bare.p_chi2 < 1e-6
        assert stated.p_chi2 > 1e-3
        assert not is_far_off(stated)
