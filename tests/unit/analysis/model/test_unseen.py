"""Campaigns without orientations: right about what positions tell, silent about friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import START, fit_campaign
from analysis.model.predict.comparison import compare
from analysis.model.predict.contact import contact_outcome, differentiated_contact
from analysis.model.predict.start import first_states
from analysis.model.predict.state import SIZE, TILT
from analysis.model.predict.theory import Theory
from analysis.model.rank.ranking import rank
from analysis.model.verdict.selection import explain
from tests.unit.analysis.model.hard_spheres import Hidden, campaign

FRICTION = {"friction-speed", "friction-drift", "rolling-restitution-speed", "inertia-factor"}


def blind(data: PoseData, spheres: tuple[int, ...] = (0, 1)) -> PoseData:
    sigma = data.rotation_sigma.copy()
    sigma[:, :, spheres] = np.inf
    return replace(data, rotation_sigma=sigma)


@pytest.mark.parametrize("spheres", [(0, 1), (0,), (1,)])
def test_restitution_is_measured_and_chi_squared_is_one(spheres: tuple[int, ...]) -> None:
    fit = fit_campaign(blind(campaign(60, 7), spheres))
    e = fit.parameters()["e"]
    assert abs(e.value - 0.74) < 4 * e.sigma < 0.004
    assert fit.chi2_per_dof == pytest.approx(1.0, abs=4 * np.sqrt(2 / fit.freedom))


def test_friction_is_not_determined_and_stays_what_was_believed_before() -> None:
    fit = fit_campaign(blind(campaign(40, 8)))
    assert fit.theory.law.mu == pytest.approx(0.08, abs=1e-6)
    assert fit.parameters()["mu"].to_json() == {"value": None, "sigma": None, "unit": "1"}


def test_effects_of_friction_cannot_be_seen() -> None:
    data = blind(campaign(40, 9))
    ranking = rank(data, fit_campaign(data), CATALOGUE)
    unseen = {c.effect.name for c in ranking.candidates if not c.seen}
    assert unseen >= FRICTION


@pytest.mark.long
def test_an_effect_on_the_normal_is_found_without_spins() -> None:
    verdict = explain(blind(campaign(60, 10, hidden=Hidden(slope=0.03))), CATALOGUE)
    assert "restitution-viscoelastic" in verdict.alias_set


def test_a_kick_keeps_momentum_and_turns_only_spheres_that_are_seen_to_turn() -> None:
    data = blind(campaign(20, 11), (1,))
    states = first_states(data)
    assert states.kick is not None
    kick = np.random.default_rng(1).normal(0, 0.5, states.kick.change.shape)
    moved = replace(states, kick=replace(states.kick, change=kick))
    change = contact_outcome(data, moved, _plain()) - contact_outcome(data, states, _plain())
    a, b = data.bodies
    assert a.mass * change[:, :3] + b.mass * change[:, 3:6] == pytest.approx(0, abs=1e-15)
    across = kick - (kick * states.normal).sum(axis=1, keepdims=True) * states.normal
    assert change[:, 3:6] - change[:, :3] == pytest.approx(across)
    lever = np.cross(a.radius * states.normal, a.mass * change[:, :3])
    assert a.inertia * change[:, 6:9] == pytest.approx(lever)
    assert change[:, 9:12] == pytest.approx(0)


def test_the_slope_by_a_kick_is_that_of_the_prediction() -> None:
    data = blind(campaign(5, 12), (0,))
    states = first_states(data)
    line, here = compare(data, states, _plain())
    for number in (12, 13, 14):
        step = np.zeros((5, 24))
        step[:, number] = 1e-4
        ahead = compare(data, states.moved(step), _plain())[1].sides
        slope = (ahead.velocity - here.sides.velocity)[:, :, 1] / 1e-4
        own = line.by_state.reshape(5, 2, 2, 2, 2, 3, 24)[:, :, 0, 1, 1, :, number]
        assert own == pytest.approx(slope, abs=1e-8)


def _plain() -> Theory:
    return fit_campaign(campaign(5, 13)).theory


def test_a_tilt_of_the_normal_is_felt_by_the_kick_as_its_derivative_says() -> None:
    data = blind(campaign(12, 12))
    states, theory = first_states(data), Theory(START)
    assert states.kick is not None
    kick = np.random.default_rng(2).normal(0, 0.5, states.kick.change.shape)
    kick -= (kick * states.normal).sum(axis=1, keepdims=True) * states.normal
    states = replace(states, kick=replace(states.kick, change=kick))
    slope = differentiated_contact(data, states, theory).by_state[..., :2]
    for k in (0, 1):
        step = np.zeros((len(kick), SIZE))
        step[:, TILT.start + k] = 1e-6
        ahead, back = (contact_outcome(data, states.moved(s * step), theory) for s in (1, -1))
        assert slope[..., k] == pytest.approx((ahead - back) / 2e-6, abs=2e-3)
