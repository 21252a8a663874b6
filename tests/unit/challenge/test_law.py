from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from simulators.challenge import HIDDEN
from simulators.challenge.effects import switched
from simulators.challenge.force_choice import Forces
from simulators.challenge.label import draw_in_contact
from simulators.challenge.law import contact_law
from simulators.challenge.nature import Nature
from simulators.laboratory import open_laboratory
from simulators.options import IN_CONTACT, read_options
from simulators.world import Launch, WorldDescription
from simulators.world.contact import Contact
from simulators.world.encounter import simulate
from simulators.world.truth import contact_truth

Floats = NDArray[np.float64]

NYLON = WorldDescription()
MASS_KG = NYLON.sphere_a.mass_kg
SPHERES = (NYLON.sphere_a, NYLON.sphere_b)


def contact_of(nature: Nature, offset_m: float = 0.008) -> Contact:
    launch = Launch(40.0, 40.0, offset_m)
    fired = simulate(NYLON, launch, np.random.default_rng(4), contact_law(nature))
    assert fired.contact is not None
    return fired.contact


def momentum(contact: Contact, moment: int, masses: tuple[float, float]) -> Floats:
    a, b = contact.motions[moment]
    return np.asarray(masses[0] * a.velocity + masses[1] * b.velocity)


@pytest.mark.parametrize("offset_m", [0.002, 0.008, 0.014])
def test_plain_spheres_rebound_with_e_and_slide_or_grip(offset_m: float) -> None:
    truth = contact_truth(contact_of(Nature(), offset_m), SPHERES)
    assert truth["v_n_after"] / truth["v_n"] == pytest.approx(-0.74, abs=1e-9)
    sliding = truth["v_s"] + 3.5 * 0.08 * 1.74 * truth["v_n"]
    gripping = -0.5 * truth["v_s"]
    assert truth["v_s_after"] == pytest.approx(max(sliding, gripping), abs=1e-6)


def test_an_instantaneous_contact_moves_nothing() -> None:
    contact = contact_of(Nature())
    assert contact.start_s == contact.end_s
    assert contact.compression_m == pytest.approx(0.0, abs=1e-12)
    for before, after in zip(contact.motions[0], contact.motions[-1], strict=True):
        np.testing.assert_allclose(after.centre, before.centre, atol=1e-12)
        np.testing.assert_allclose(after.orientation, before.orientation, atol=1e-12)


def test_a_soft_contact_lasts_and_its_spheres_run_on_without_a_jump() -> None:
    contact = contact_of(Nature(softness=1.0))
    assert 1e-4 < contact.end_s - contact.start_s < 4e-4
    assert contact.compression_m > 1e-5
    for index in (0, 1):
        for time, motions in zip(contact.times_s[1:-1], contact.motions[1:-1], strict=True):
            reached = contact.pose(index, float(time) - 1e-12)
            np.testing.assert_allclose(reached.centre, motions[index].centre, atol=1e-7)
            np.testing.assert_allclose(reached.orientation, motions[index].orientation, atol=1e-5)


def test_the_duration_in_the_truth_is_that_of_the_overlap_not_how_long_it_was_followed() -> None:
    forces = Forces(duration_s=2e-4)
    truth = contact_truth(contact_of(Nature(forces=forces)), SPHERES)
    undamped_s = forces.duration_s * abs(truth["v_n"]) ** -0.2
    # Hertz and Tsuji at e = 0.74, head on: 1.038 of the undamped contact.
    assert truth["contact_duration_s"] == pytest.approx(1.038 * undamped_s, rel=0.01)
    assert contact_truth(contact_of(Nature()), SPHERES)["contact_duration_s"] == 0.0


def test_unequal_masses_share_one_momentum() -> None:
    contact = contact_of(Nature(mass_difference=0.05))
    masses = (1.05 * MASS_KG, 0.95 * MASS_KG)
    change = momentum(contact, -1, masses) - momentum(contact, 0, masses)
    np.testing.assert_allclose(change, 0.0, atol=1e-12)
    equal = momentum(contact, -1, (MASS_KG, MASS_KG)) - momentum(contact, 0, (MASS_KG, MASS_KG))
    assert np.linalg.norm(equal) > 1e-4


@pytest.mark.parametrize("name", [*IN_CONTACT, "friction-spin", "restitution-grain"])
def test_every_effect_of_the_contact_changes_how_spheres_part(name: str) -> None:
    plain = contact_of(Nature(), 0.012)
    changed = contact_of(switched({name: HIDDEN[name].amplitude}), 0.012)
    before = [(motion.velocity, motion.spin) for motion in plain.motions[0]]
    np.testing.assert_array_equal(before, [(m.velocity, m.spin) for m in changed.motions[0]])
    parted = [(m.velocity, 0.0127 * m.spin) for m in plain.motions[-1]]
    otherwise = [(m.velocity, 0.0127 * m.spin) for m in changed.motions[-1]]
    assert np.abs(np.subtract(parted, otherwise)).max() > 1e-3


@pytest.mark.parametrize("pressure_kpa", [75.0, 30.0])
def test_a_bump_of_restitution_acts_at_its_own_speed(pressure_kpa: float) -> None:
    struck = contact_law(switched({"restitution-bump": 0.02}))
    launch = Launch(pressure_kpa, pressure_kpa, 0.002)
    contact = simulate(NYLON, launch, np.random.default_rng(4), struck).contact
    assert contact is not None
    truth = contact_truth(contact, SPHERES)
    bump = 0.02 * np.exp(-0.5 * ((abs(truth["v_n"]) - 5.0) / 0.6) ** 2)
    assert -truth["v_n_after"] / truth["v_n"] == pytest.approx(0.74 * (1 + bump), abs=1e-9)


def test_a_draw_takes_every_effect_of_the_contact_and_a_name_only_its_own() -> None:
    rng = np.random.default_rng(2)
    assert {name for _ in range(200) for name in draw_in_contact(rng)} == set(IN_CONTACT)
    signs = {draw_in_contact(rng, "mass-mismatch")["mass-mismatch"] for _ in range(20)}
    assert signs == {0.01, -0.01}


def test_a_laboratory_that_hides_something_seals_its_label(tmp_path: Path) -> None:
    for folder, hides in (("plain", ""), ("hiding", "drawn")):
        laboratory = open_laboratory(tmp_path / folder, {"seed": 3, "hides": hides})
        laboratory.close()
    assert not (tmp_path / "plain/truth/sealed.txt").exists()
    public = json.loads((tmp_path / "hiding/truth/challenge.json").read_text())
    assert set(IN_CONTACT) <= set(public["names"])
    assert (tmp_path / "hiding/truth/sealed.txt").exists()


@pytest.mark.parametrize("value", ["drag", "nothing", 1, None])
def test_what_no_contact_can_hide_is_refused_by_name(value: object) -> None:
    with pytest.raises(ValueError, match=r"simulation\.hides"):
        read_options({"hides": value})
