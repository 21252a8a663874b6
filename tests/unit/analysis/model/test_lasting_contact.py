"""Contacts that last, of the simulators' making, found and fitted."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from analysis.collision.force_law import hertz_duration
from analysis.effects.catalogue import CATALOGUE
from analysis.effects.contact.lasting_contact import EFFECT, contact_modulus
from analysis.model.data.poses import PoseData
from analysis.model.fitting.account import AS_STATED
from analysis.model.fitting.robust_fit import RobustFit, robust_fit
from analysis.model.rank.ranking import rank
from analysis.model.verdict.selection import explain
from benchmarks.discovery.campaigns import posed
from benchmarks.discovery.filmed_errors import filmed
from simulators.challenge.campaign import Noise, run_campaign
from simulators.challenge.force_choice import Forces
from simulators.challenge.nature import Nature
from tests.unit.analysis.model.chosen import chosen

AIR = 0.4


@cache
def poses(forces: Forces, shots: int = 60, seed: int = 42) -> PoseData:
    nature = Nature(forces=forces, drag_coefficient=AIR)
    return replace(posed(run_campaign(nature, seed, shots=shots)), drag_coefficient=0.42)


@cache
def fitted(forces: Forces) -> RobustFit:
    return robust_fit(poses(forces), [EFFECT])


@cache
def fitted_as_hard(forces: Forces) -> RobustFit:
    """The fit of the law of hard spheres to contacts that last."""
    return robust_fit(poses(forces))


INCREMENTS = Forces(drag="increment", stiffness_ratio=0.6, damping_ratio=0.1)
LINEAR = Forces(push="linear", stiffness_ratio=0.3, damping_ratio=0.1)
SOFT = Forces(duration_s=4e-4, stiffness_ratio=0.25, damping_ratio=0.08)
FASTER_IS_BOUNCIER = Forces(push="hertz-dashpot", stiffness_ratio=0.5, damping_ratio=0.05)


@pytest.mark.parametrize(
    "forces",
    [
        INCREMENTS,
        pytest.param(LINEAR, marks=pytest.mark.long),
        SOFT,
        pytest.param(FASTER_IS_BOUNCIER, marks=pytest.mark.long),
    ],
)
def test_a_fit_with_the_lasting_contact_reaches_the_noise(forces: Forces) -> None:
    found = fitted(forces)
    spread = np.sqrt(2 / found.fit.freedom)
    assert found.fit.chi2_per_dof < 1.0 + 3 * spread
    assert found.evidence.noise == AS_STATED


@pytest.mark.parametrize(
    "forces", [INCREMENTS, SOFT, pytest.param(FASTER_IS_BOUNCIER, marks=pytest.mark.long)]
)
def test_its_parameters_are_those_of_the_simulated_contact(forces: Forces) -> None:
    found = fitted(forces).fit.parameters()
    truth = {
        "e": 0.74,
        "mu": 0.08,
        "lasting-contact.kappa": forces.stiffness_ratio,
        "lasting-contact.zeta": forces.damping_ratio,
    }
    for name, value in truth.items():
        assert abs(found[name].value - value) < 4 * found[name].sigma + 2e-4, name
    assert found["lasting-contact.t"].value == pytest.approx(forces.duration_s, rel=0.02)


def test_a_law_of_its_own_has_no_beta0() -> None:
    assert "beta0" not in fitted(SOFT).fit.parameters()
    assert "beta0" in fitted_as_hard(SOFT).fit.parameters()


def test_the_verdict_names_it_alone_and_what_it_contains_is_offered_no_more() -> None:
    verdict = explain(poses(INCREMENTS), CATALOGUE)
    assert (verdict.verdict, verdict.effects) == ("effect", ("lasting-contact",))
    offered = {candidate.effect.name for candidate in verdict.ranking.candidates}
    assert not offered & {*EFFECT.contains, EFFECT.name}


@pytest.mark.long
def test_torsion_on_top_of_it_is_named_by_ten_shots_as_exact_as_films() -> None:
    torsion = Nature(forces=Forces(), torsion_radius_m=8e-4, drag_coefficient=AIR)
    data = replace(filmed(torsion, 1, 10, 0.001), drag_coefficient=0.42)
    verdict = explain(data, CATALOGUE)
    assert verdict.verdict == "effect"
    assert set(verdict.effects) == {"torsional-friction", EFFECT.name}
    # Slow errors that bend within a flight are not in the noise of its frames.
    assert verdict.fit.chi2_per_dof < 1.0 + 4 * np.sqrt(2 / verdict.fit.freedom)


def test_its_share_leads_the_candidates_of_the_hard_sphere_law() -> None:
    found = fitted_as_hard(SOFT)
    leaders = [c.effect.name for c in rank(found.data, found.fit, CATALOGUE).candidates[:3]]
    assert set(leaders) & {"lasting-contact", "finite-contact"}


def test_hard_spheres_have_no_lasting_contact() -> None:
    nature = Nature(drag_coefficient=AIR, compliance=1.0)
    data = replace(posed(run_campaign(nature, 44, shots=60)), drag_coefficient=0.42)
    assert "lasting-contact" not in explain(data, CATALOGUE).effects


def test_without_spins_the_law_across_the_normal_stays_open() -> None:
    data = poses(SOFT)
    blind = data.with_sigmas(data.position_sigma, np.full_like(data.rotation_sigma, np.inf))
    found = robust_fit(blind, [EFFECT]).fit.parameters()
    assert not found["mu"].determined
    assert not found["beta0"].determined
    assert found["e"].value == pytest.approx(0.74, abs=0.02)


@pytest.mark.parametrize(
    "short", ["shots", pytest.param("frames", marks=pytest.mark.long)], ids=str
)
def test_few_shots_and_frames_give_e_and_no_error(short: str) -> None:
    data = poses(SOFT)
    if short == "shots":
        few = data.of_shots(np.arange(60) == 3)
    else:
        frames = np.abs(np.arange(data.times_s.shape[1]) - 11.5) > 5
        few = data.without(np.tile(frames, (60, 1))).of_shots(np.arange(60) < 20)
    assert robust_fit(few, [EFFECT]).fit.parameters()["e"].value == pytest.approx(0.74, abs=0.03)
    assert explain(few, chosen("drag", "lasting-contact")).verdict in {"none", "effect"}


def test_a_drag_that_is_stated_is_no_finding_and_three_times_as_much_is() -> None:
    thrice = Nature(forces=SOFT, drag_coefficient=3 * AIR)
    data = replace(posed(run_campaign(thrice, 43, shots=60)), drag_coefficient=0.42)
    drag = fitted(SOFT).fit.systematics()["drag.Cd"]
    assert abs(drag.value - AIR) < 3 * drag.sigma
    named = robust_fit(data, [EFFECT, *chosen("drag")]).fit.parameters()["drag.Cd"]
    assert abs(named.value - 3 * AIR) < 3 * named.sigma


def test_modulus_and_duration_are_each_others_inverse() -> None:
    bodies = poses(SOFT).bodies
    # Nylon of 3 GPa and Poisson's ratio 0.4, two one-inch spheres: 0.19 ms at 1 m/s.
    modulus = 3e9 / (2 * (1 - 0.4**2))
    assert hertz_duration(modulus, bodies) == pytest.approx(1.878e-4, rel=1e-3)
    assert contact_modulus(hertz_duration(modulus, bodies), bodies) == pytest.approx(modulus)


def test_a_scale_that_is_off_as_stated_leads_to_no_other_law() -> None:
    """Twelve shots as precise as films give them; every length 0.15 % too long."""
    noise = Noise(centre_px=0.0075, rotation_rad=4e-4)
    nature = Nature(forces=Forces(), drag_coefficient=AIR)
    exact = posed(run_campaign(nature, 1, shots=12, noise=noise))
    long = replace(exact, position=1.0015 * exact.position, drag_coefficient=0.42)
    data = replace(long, slow=replace(long.slow, scale=1e-3))
    found = robust_fit(data, [EFFECT]).fit
    named = found.parameters()
    assert named["lasting-contact.kappa"].value == pytest.approx(0.15, abs=2e-3)
    assert named["lasting-contact.zeta"].value == pytest.approx(0.05, abs=0.01)
    assert abs(found.systematics()["image-scale.s"].value - 1.5e-3) < 4e-4
