"""What tabulated contacts can show of missing physics, and what they cannot."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.collision.operator import Encounter, States
from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import ContactEffect
from analysis.model.agreement.agree import agree
from analysis.model.data.gather import gather
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import fit_campaign
from analysis.model.plane import impact_plane
from analysis.model.rank.ranking import rank
from analysis.model.rank.scatter import timing_jitter
from analysis.model.structure.structure import structure
from analysis.model.verdict.documents import verdict_report
from analysis.model.verdict.selection import explain
from analysis.model.verdict.words import verdict_sentence
from tests.unit.analysis.model.chosen import chosen
from tests.unit.analysis.model.exchange_folder import DESCRIPTION
from tests.unit.analysis.model.tabulated import PLATE, contacts, folder_with, impacts, walton

CONTACT = tuple(effect for effect in CATALOGUE if isinstance(effect, ContactEffect))
SPEED_FAMILY = {"restitution-viscoelastic", "restitution-yield-knee", "restitution-plastic"}
# Rebound of a compliant solid sphere of Poisson's ratio 1/4, kappa v_s' / (mu v_n) against
# kappa v_s / (mu v_n), as tabulated from Maw, Barber and Fawcett's theory.
PSI = [0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0, 7.0]
REBOUND = [
    *(0.0562, 0.0814, 0.0154, -0.3296, -0.7442, -1.0882, -1.3345),
    *(-1.4720, -1.4864, -1.3501, -1.0, 0.0, 1.0),
]


def table(folder: Path) -> ContactTable:
    data = gather(folder)[1]
    assert isinstance(data, ContactTable)
    return data


@pytest.mark.parametrize("write", [contacts, impacts])
def test_effects_of_flight_camera_clock_and_body_cannot_be_seen(tmp_path: Path, write) -> None:
    data = table(write(tmp_path, 30, 1))
    ranking = rank(data, fit_campaign(data), CATALOGUE)
    unseen = {c.effect.name for c in ranking.candidates if not c.seen}
    assert {e.name for e in CATALOGUE if e.stage != "contact"} <= unseen
    for candidate in ranking.candidates:
        if candidate.seen:
            assert np.isfinite([*candidate.amplitudes, *candidate.sigmas, candidate.score]).all()
        else:
            assert candidate.delta_chi2 == 0.0


def test_scalars_of_like_spheres_show_neither_masses_nor_spins_about_the_normal(
    tmp_path: Path,
) -> None:
    data = table(impacts(tmp_path, 30, 2))
    ranking = rank(data, fit_campaign(data), CONTACT)
    unseen = {c.effect.name for c in ranking.candidates if not c.seen}
    # The inertia takes part only in mu (1 + 1/K), which friction fits.
    assert {"mass-mismatch", "torsional-friction", "inertia-factor"} <= unseen


def test_full_states_show_masses_inertia_and_spins_about_the_normal(tmp_path: Path) -> None:
    data = table(contacts(tmp_path, 30, 2))
    ranking = rank(data, fit_campaign(data), CONTACT)
    seen = {c.effect.name for c in ranking.candidates if c.seen}
    assert {"mass-mismatch", "torsional-friction", "inertia-factor"} <= seen


def test_timing_jitter_cannot_be_seen(tmp_path: Path) -> None:
    data = table(contacts(tmp_path, 10, 3))
    assert timing_jitter(data, fit_campaign(data)) is None


def test_restitution_that_falls_with_speed_is_found(tmp_path: Path) -> None:
    for k, data in enumerate(
        (
            table(impacts(tmp_path / "scalars", 60, 4, slope=0.04)),
            table(contacts(tmp_path / "states", 60, 5, slope=0.06)),
        )
    ):
        verdict = explain(data, CATALOGUE)
        assert len(verdict.effects) == 1, k
        assert set(verdict.effects) | set(verdict.alias_set) <= SPEED_FAMILY | {"velocity-offset"}
        assert verdict.effects[0] in SPEED_FAMILY
        assert verdict.path[-1].error.value < verdict.path[0].error.value


def test_the_slope_of_restitution_is_the_one_that_was_put_in(tmp_path: Path) -> None:
    data = table(impacts(tmp_path, 80, 6, slope=0.02))
    (effect,) = chosen("restitution-viscoelastic")
    base = fit_campaign(data)
    fit = fit_campaign(data, base.theory.with_effect(effect), base)
    found = fit.parameters()["restitution-viscoelastic.a"]
    assert found.value == pytest.approx(0.02, abs=4 * found.sigma)
    assert found.sigma < 0.004


def test_friction_that_depends_on_the_speed_is_found_at_its_size(tmp_path: Path) -> None:
    data = table(impacts(tmp_path, 60, 7, friction_slope=0.12))
    verdict = explain(data, CATALOGUE)
    assert verdict.effects == ("friction-speed",)
    found = verdict.fit.parameters()["friction-speed.a"]
    assert found.value == pytest.approx(0.12, abs=4 * found.sigma)
    document = verdict_report("published", data, verdict)
    assert document.used == 60
    assert "published: the missing effect is friction-speed" in verdict_sentence(document)


def test_a_compliant_contact_is_found_from_the_published_curve(tmp_path: Path) -> None:
    rng, mu, e, sigma = np.random.default_rng(8), 0.2, 1.0, 0.01
    rows: list[list[object]] = [["shot", "v_n", "v_s", "v_n_after", "v_s_after"]]
    rows[0] += [f"sigma_{name}" for name in rows[0][1:]]
    for s, (psi, rebound) in enumerate(zip(PSI * 5, REBOUND * 5, strict=True)):
        v_n = rng.uniform(2.0, 5.0)
        unit = mu * v_n / (6 / 7)
        speeds = np.array([-v_n, unit * psi, e * v_n, unit * rebound]) + rng.normal(0, sigma, 4)
        rows.append([s + 1, *map(float, [speeds[0], abs(speeds[1]), *speeds[2:]]), *[sigma] * 4])
    data = table(folder_with(tmp_path, "impacts.csv", rows, DESCRIPTION))
    verdict = explain(data, CATALOGUE)
    assert verdict.effects[0] == "tangential-compliance"
    found = verdict.fit.parameters()["tangential-compliance.a"]
    assert found.value == pytest.approx(1.0, abs=max(4 * found.sigma, 0.1))


def test_nothing_is_found_where_nothing_is_missing(tmp_path: Path) -> None:
    for seed, write in enumerate((contacts, impacts, contacts, impacts)):
        verdict = explain(table(write(tmp_path / str(seed), 40, 30 + seed)), CATALOGUE)
        assert (verdict.verdict, verdict.effects, verdict.noise) == ("none", (), (1.0, 1.0))


def test_an_effect_is_found_without_stated_errors(tmp_path: Path) -> None:
    data = table(impacts(tmp_path, 60, 9, friction_slope=0.12, sigma=None))
    verdict = explain(data, CATALOGUE)
    assert verdict.effects == ("friction-speed",)
    # The scatter about the base model held the effect too; what is left is the noise.
    assert np.median(verdict.cleaned.data.sigma) == pytest.approx(0.01, rel=0.25)
    assert verdict.path[-1].error.value == pytest.approx(1.0, abs=0.25)


def test_agreement_is_that_of_what_contact_leaves_behind(tmp_path: Path) -> None:
    states, scalars = (
        table(contacts(tmp_path / "a", 40, 10)),
        table(impacts(tmp_path / "b", 40, 11)),
    )
    for data, count in ((states, 12), (scalars, 2)):
        found = agree(data, fit_campaign(data))
        assert [stage.name for stage in found.stages] == ["after contact"]
        assert sum(row.count for row in found.stages[0].rows) == 40 * count
        assert all(row.p_holm > 0.01 for row in found.stages[0].rows)
        assert sum(row.freedom for row in found.stages[0].rows) == pytest.approx(
            40 * count - 3, abs=0.5
        )


def test_structure_shows_the_speed_that_restitution_falls_with(tmp_path: Path) -> None:
    data = table(impacts(tmp_path, 60, 12, slope=0.05))
    found = structure(data, fit_campaign(data))
    assert (found.cells[0].channel, found.cells[0].covariate) == ("relative velocity n", "ln v_n")
    cell = found.residuals("relative velocity n", "ln v_n")
    assert len(cell.shots) == 60
    with pytest.raises(KeyError):
        found.residuals("image X", "field X")


@pytest.mark.parametrize("description", [None, PLATE])
def test_the_plane_of_surface_velocities_holds_the_tabulated_shots(
    tmp_path: Path, description: str | None
) -> None:
    extra = {} if description is None else {"description": description}
    data = table(impacts(tmp_path, 30, 13, noise=1e-4, sigma=1e-4, **extra))
    plane = impact_plane(data, fit_campaign(data))
    v_n, v_s, _, v_s_after = data.numbers.T
    assert plane.shots.tolist() == data.shots.tolist()
    assert plane.x == pytest.approx(v_s / -v_n, abs=2e-3)
    assert plane.y == pytest.approx(v_s_after / -v_n, abs=2e-3)


def test_a_plate_gives_back_the_law(tmp_path: Path) -> None:
    data = table(impacts(tmp_path, 60, 14, description=PLATE))
    fit = fit_campaign(data)
    assert data.bodies[1].is_plate
    assert (
        np.abs(fit.theory.vector - (0.74, 0.08, 0.5)) < 4 * np.sqrt(np.diag(fit.covariance))
    ).all()
    assert (fit.states.before.velocity_b == 0).all()


def bounced(shots: int, seed: int) -> list[list[object]]:
    """Return contacts.csv of a solid sphere on a plate, worked out in scalars."""
    rng = np.random.default_rng(seed)
    axes = [
        f"{k}{s}_{x}{after}" for after in ("", "_after") for k in "vw" for s in "ab" for x in "xyz"
    ]
    rows: list[list[object]] = [
        ["shot", "nx", "ny", "nz", *axes, "sigma_v_m_per_s", "sigma_w_rad_per_s"]
    ]
    for s in range(shots):
        v_n, v_s = rng.uniform(1.0, 4.0), rng.uniform(0.1, 4.0)
        # The sphere falls along +X onto a plate below it, slides along +Y, does not spin.
        n_after, s_after = walton(v_n, v_s, (0.74, 0.08, 0.5))
        change = (v_s - s_after) * 2 / 7
        spin = (v_s - s_after) * 5 / 7 / 0.0127
        before = np.array([v_n, v_s, 0.0, 0.0, 0.0, 0.0])
        # At the lowest point, R X from the centre, v_y - R w_z is left of the surface velocity.
        after = np.array([-n_after, v_s - change, 0.0, 0.0, 0.0, -spin])
        noise = np.repeat([0.004, 0.4], 3)
        a, b = (state + rng.normal(0, noise) for state in (before, after))
        empty = [""] * 3
        fields = [*map(float, a[:3]), *empty, *map(float, a[3:]), *empty]
        fields += [*map(float, b[:3]), *empty, *map(float, b[3:]), *empty]
        rows.append([s + 1, 1.0, 0.0, 0.0, *fields, 0.004, 0.4])
    return rows


def test_full_states_on_a_plate_give_back_the_law(tmp_path: Path) -> None:
    data = table(folder_with(tmp_path, "contacts.csv", bounced(60, 15), PLATE))
    fit = fit_campaign(data)
    assert (
        np.abs(fit.theory.vector - (0.74, 0.08, 0.5)) < 4 * np.sqrt(np.diag(fit.covariance))
    ).all()
    assert fit.freedom == 60 * 6 - 3
    assert fit.chi2_per_dof == pytest.approx(1.0, abs=4 * np.sqrt(2 / fit.freedom))
    assert explain(data, CATALOGUE).verdict == "none"
    rows = agree(data, fit).stages[0].rows
    assert sum(row.count for row in rows) == 60 * 6


def test_what_makes_no_sense_on_a_plate_is_not_offered_or_cannot_be_seen(tmp_path: Path) -> None:
    data = table(folder_with(tmp_path, "contacts.csv", bounced(30, 16), PLATE))
    ranking = rank(data, fit_campaign(data), CATALOGUE)
    unseen = {c.effect.name for c in ranking.candidates if not c.seen}
    assert {"finite-contact", "mass-offset"} <= unseen
    offered = {c.effect.name for c in ranking.candidates}
    assert not offered & {"mass-mismatch", "radius-mismatch"}
    assert {"restitution-viscoelastic", "friction-speed"}.isdisjoint(unseen)


@pytest.mark.parametrize("effect", CONTACT, ids=lambda effect: effect.name)
def test_every_contact_effect_is_finite_on_a_plate_and_leaves_it_at_rest(
    tmp_path: Path, effect: ContactEffect
) -> None:
    data = table(folder_with(tmp_path, "contacts.csv", bounced(8, 17), PLATE))
    base = fit_campaign(data).theory
    values = np.array([max(p.plausible, key=abs) for p in effect.parameters])
    shots = len(data.shots)
    before = replace(data.start, spin_a=data.start.spin_a + 30.0)
    encounter = Encounter(
        before=before,
        normal=data.normal,
        bodies=data.bodies,
        e=np.full(shots, 0.74),
        mu=np.full(shots, 0.08),
        beta0=np.full(shots, 0.5),
        covariates=data.covariates,
    )
    outcome = effect.wrap(base.operator, values)(encounter)
    after: States = outcome.after
    numbers = [after.velocity_a, after.spin_a, outcome.duration, outcome.shift_a, outcome.turn_a]
    assert all(np.isfinite(part).all() for part in numbers)
    assert (after.velocity_b == 0).all()
    assert (after.spin_b == 0).all()
