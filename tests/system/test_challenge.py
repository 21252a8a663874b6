"""Challenges through the readers and the fit of the analysis, as a user meets them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.exchange.description import read_description
from analysis.exchange.pose_table import read_poses
from analysis.exchange.shot_list import read_shot_list
from analysis.model.data.gather import gather
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from simulators.challenge import HIDDEN, write_challenge
from simulators.challenge.camera import OPTICS, apparent
from simulators.challenge.campaign import FRAME_RATE_HZ, fire, run_campaign
from simulators.challenge.effects import switched
from simulators.challenge.folder import write_folder
from simulators.challenge.launch import FILMED_PRESSURES_KPA
from simulators.challenge.making import campaign_seed
from simulators.challenge.nature import Nature
from tests.system.test_documentation import DOCS, needs_shell, perform

pytestmark = pytest.mark.long


def test_the_readers_of_the_analysis_find_every_number_again(tmp_path: Path) -> None:
    campaign = run_campaign(Nature(), 3, shots=5)
    write_folder(tmp_path / "nylon", campaign)
    name, setup = read_description(tmp_path / "nylon/campaign.toml")
    assert (name, setup.camera.width_px, setup.camera.scale_px_per_m) == ("nylon", 400, 1574.8)
    shots = read_shot_list(tmp_path / "nylon/shots.csv")
    assert [row.numbers["offset_mm"] for row in shots] == campaign.settings.offset_mm.tolist()
    assert {"pressure_a_kpa", "pressure_b_kpa", "temperature_c"} < set(shots[0].numbers)
    poses = read_poses(tmp_path / "nylon/poses.csv")
    for shot in range(5):
        for i, sphere in enumerate("ab"):
            rows = poses[shot + 1][sphere]
            found = np.array([row.position for row in rows])
            np.testing.assert_array_equal(found, campaign.centres[shot, :, i])
            turned = np.array([row.quaternion for row in rows])
            np.testing.assert_allclose(turned, campaign.orientations[shot, :, i], atol=1e-12)
            assert {row.position_sigma[0] for row in rows} == {campaign.centre_sigma_m}


def test_a_campaign_that_hides_nothing_fits_to_its_noise(tmp_path: Path) -> None:
    write_challenge(tmp_path / "x", {}, seed=11, shots=60)
    fitted = fit_campaign(gather(tmp_path / "x")[1])
    assert fitted.chi2_per_dof == pytest.approx(1.0, abs=4 * np.sqrt(2 / fitted.freedom))
    truth = {"e": 0.74, "mu": 0.08, "beta0": 0.5}
    for name, value in truth.items():
        found = fitted.parameters()[name]
        assert abs(found.value - value) < 4 * found.sigma


EXACT = [
    *("camera-roll", "drag", "friction-drift", "gravity-direction", "image-scale"),
    *("inertia-factor", "mass-mismatch", "mirror-angle", "pixel-aspect", "radial-distortion"),
    *("restitution-drift", "restitution-obliquity", "restitution-plastic", "torsional-friction"),
]
"""Effects whose amplitude means the same in the catalogue."""
OF_TWO_AXES = {"gravity-direction": 0.8}


@pytest.mark.parametrize("name", EXACT)
def test_the_hidden_amplitude_is_found_by_the_effect_of_that_name(
    name: str, tmp_path: Path
) -> None:
    write_challenge(tmp_path / "x", {name: HIDDEN[name].amplitude}, seed=12, shots=60)
    _, data = gather(tmp_path / "x")
    effect = next(effect for effect in CATALOGUE if effect.name == name)
    plain = fit_campaign(data)
    fitted = fit_campaign(data, plain.theory.with_effect(effect), plain)
    found = fitted.parameters()[f"{name}.{effect.parameters[0].symbol}"]
    hidden = HIDDEN[name].amplitude * OF_TWO_AXES.get(name, 1.0)
    assert abs(found.value - hidden) < 4 * found.sigma + 0.02 * abs(hidden)
    assert fitted.chi2_per_dof == pytest.approx(1.0, abs=4 * np.sqrt(2 / fitted.freedom))


def test_every_name_that_a_challenge_can_ask_for_is_in_the_catalogue() -> None:
    asked = {effect.name for effect in HIDDEN.values() if effect.known}
    also = {name for effect in HIDDEN.values() for name in (*effect.like, *effect.beside)}
    assert asked | also <= {effect.name for effect in CATALOGUE}


FILMED_SHOTS, LEAST_MEASURED = 4, 3


@pytest.mark.timeout(600)
def test_frames_of_a_challenge_are_measured_where_its_poses_say_the_spheres_are(
    tmp_path: Path,
) -> None:
    hidden = {"mirror-angle": 0.01, "restitution-obliquity": 0.03}
    folder = tmp_path / "filmed"
    write_challenge(folder, hidden, seed=5, shots=FILMED_SHOTS, from_frames=True)
    _, found = gather(folder)
    assert isinstance(found, PoseData)
    assert len(found.shots) >= LEAST_MEASURED
    shots = found.shots - 1
    nature, seed = switched(hidden), campaign_seed(5)
    fired = fire(nature, seed, shots=FILMED_SHOTS, pressures_kpa=FILMED_PRESSURES_KPA)
    seen = apparent(fired.way.centres, np.broadcast_to(fired.times_s, (4, 24)), nature, OPTICS)
    for k, shot in enumerate(shots):
        frames = np.rint(found.times_s[k] * FRAME_RATE_HZ).astype(int)
        known = np.isfinite(found.position_sigma[k]).all(axis=-1)
        off = (found.position[k] - seen[shot, frames])[known] * OPTICS.scale_px_per_m
        assert known.sum() > 30
        # A turned mirror moves all that both views are read from: alike, and in no velocity.
        alike = off.mean(axis=0)
        assert np.abs(alike).max() < 0.15
        assert np.sqrt(((off - alike) ** 2).mean()) < 0.03


@needs_shell
@pytest.mark.timeout(600)
def test_the_guide_to_challenges_makes_one_in_poses_and_one_in_frames(tmp_path: Path) -> None:
    said = perform(DOCS / "how-to" / "take-a-challenge.md", tmp_path)
    assert "answered mirror-angle; the truth is mirror-angle" in said
    assert len((tmp_path / "measured/contacts.csv").read_text().splitlines()) > 1
