"""Poses of two spheres of unlike size and mass: the law of their contact is found within errors."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rigctl import cli
from simulators.challenge.unlike import Motion, Pair, contact, film
from tests.unit.analysis.model.dropped import COLUMNS

PAIR = Pair()
SHOTS, RATE_HZ, SIGMA_M, SIGMA_RAD = 40, 1000.0, 1e-5, 1e-3
DESCRIPTION = """\
format = 1
name = "unlike"
[camera]
frame_rate_hz = 1000.0
width_px = 240
height_px = 192
scale_px_per_m = 1574.8
[[spheres]]
name = "a"
diameter_m = 0.0254
density_kg_per_m3 = 1150.0
[[spheres]]
name = "b"
diameter_m = 0.016
density_kg_per_m3 = 2500.0
"""


def meeting(rng: np.random.Generator) -> Motion:
    """Return two spheres as they touch at 1 to 4 m/s, up to 0.8 of the largest offset."""
    beside = rng.uniform(0.0, 0.8)
    around = Rotation.from_rotvec(rng.normal(0.0, 0.2, 3))
    n = around.apply([beside, np.sqrt(1.0 - beside**2), 0.0])
    speed = around.apply([0.0, rng.uniform(1.0, 4.0), 0.0])
    radii = np.array(PAIR.radii_m)
    return Motion(
        np.array([-radii[0] * n, radii[1] * n]),
        np.array([0.5 * speed, -0.5 * speed]),
        rng.normal(0.0, 20.0, (2, 3)),
        (Rotation.random(rng=rng), Rotation.random(rng=rng)),
    )


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("unlike")
    rng = np.random.default_rng(12)
    (folder / "campaign.toml").write_text(DESCRIPTION, encoding="utf-8")
    numbers = "".join(f"{n}\n" for n in range(1, SHOTS + 1))
    (folder / "shots.csv").write_text("shot\n" + numbers, encoding="utf-8")
    with (folder / "poses.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS.split())
        for shot in range(1, SHOTS + 1):
            times = (np.arange(24.0) - 12.0 + float(rng.uniform(0.1, 0.7))) / RATE_HZ
            places, turns = film(PAIR, meeting(rng), times)
            places = places + rng.normal(0.0, SIGMA_M, places.shape)
            for i, sphere in enumerate("ab"):
                wrong = Rotation.from_rotvec(rng.normal(0.0, SIGMA_RAD, (24, 3)))
                seen = wrong * Rotation.from_quat(turns[:, i], scalar_first=True)
                for k, turned in enumerate(seen.as_quat(scalar_first=True)):
                    place = (*places[k, i], *(SIGMA_M,) * 3)
                    row = (shot, k, times[k] - times[0], sphere, *place, *turned, SIGMA_RAD)
                    writer.writerow(row)
    return folder


def test_momentum_and_its_moment_are_kept_by_the_simulated_contact() -> None:
    touch = meeting(np.random.default_rng(3))
    parted, lasted = contact(PAIR, touch)
    masses, inertias = PAIR.masses_kg[:, None], PAIR.inertias[:, None]

    def whole(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
        linear = (masses * motion.velocities).sum(axis=0)
        middle = (masses * motion.places).sum(axis=0) / masses.sum()
        orbital = np.cross(motion.places - middle, masses * motion.velocities).sum(axis=0)
        return linear, orbital + (inertias * motion.spins).sum(axis=0)

    free = touch.later(lasted)
    assert np.allclose(whole(parted)[0], whole(free)[0], rtol=1e-9)
    # Levers reach into the overlap, as forces act on one plane: what is left is its rounding.
    assert np.allclose(whole(parted)[1], whole(free)[1], rtol=1e-3)


@pytest.mark.long
def test_the_law_of_unlike_spheres_is_found_from_their_poses(
    campaign: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["model", "fit", str(campaign), "--with", "lasting-contact", "--json"]) == 0
    fit = json.loads(capsys.readouterr().out)
    assert fit["chi2_per_dof"] == pytest.approx(1.0, abs=4 * np.sqrt(2 / fit["degrees_of_freedom"]))
    found = fit["parameters"]
    frontal = Motion(
        np.array([[0.0, -PAIR.radii_m[0], 0.0], [0.0, PAIR.radii_m[1], 0.0]]),
        np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]),
        np.zeros((2, 3)),
        (Rotation.identity(), Rotation.identity()),
    )
    parted, _ = contact(PAIR, frontal)
    truth = {
        "e": float(parted.velocities[1, 1] - parted.velocities[0, 1]) / 2.0,
        "mu": PAIR.friction,
        "lasting-contact.kappa": PAIR.stiffness_ratio,
        "lasting-contact.zeta": PAIR.tangential_damping,
    }
    for name, value in truth.items():
        assert abs(found[name]["value"] - value) < 4 * found[name]["sigma"] + 2e-4, name
    lasts = found["lasting-contact.t"]
    assert abs(lasts["value"] - PAIR.duration_s) < 4 * lasts["sigma"] + 0.02 * PAIR.duration_s


@pytest.mark.long
@pytest.mark.timeout(600)
def test_nothing_but_the_contact_is_named_for_unlike_spheres(
    campaign: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["model", "explain", str(campaign), "--json"]) == 0
    verdict = json.loads(capsys.readouterr().out)
    assert (verdict["verdict"], verdict["effects"]) == ("effect", ["lasting-contact"])
