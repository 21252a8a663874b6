"""Cameras with a known fault, filmed by the simulators, against what their shots say."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
import tifffile

from analysis.calibration.calibrate import calibrate
from analysis.campaign import read_campaign
from analysis.effects.catalogue import CATALOGUE
from analysis.errors import InputError
from simulators.world import WorldDescription, write_campaign
from simulators.world.optics import Optics

pytestmark = pytest.mark.long

OPTICS = Optics(exposure_s=0.0)
SEED, PRESSURES, OFFSETS = 4, [40.0, 60.0, 80.0], [3.0, 8.0, 6.0]
NEARNESS_PER_M = 1.0


def filmed(folder, optics, shots=3):
    write_campaign(
        folder,
        PRESSURES[:shots],
        OFFSETS[:shots],
        SEED,
        description=WorldDescription(optics=optics),
        frames=16,
        state_scale=False,
    )
    return folder


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return filmed(tmp_path_factory.mktemp("plain"), OPTICS)


def stretched(folder, source, share):
    """Copy a campaign with its rows stretched about the frame's middle."""
    (folder / "frames").mkdir()
    for name in ("campaign.toml", "shots.csv"):
        (folder / name).write_text((source / name).read_text())
    down, across = np.mgrid[: OPTICS.rows, : OPTICS.columns].astype(np.float32)
    middle = (OPTICS.rows - 1) / 2
    down = ((down - middle) / (1 + share) + middle).astype(np.float32)
    for path in (source / "frames").iterdir():
        frames = tifffile.imread(path).astype(np.float32)
        moved = [
            cv2.remap(f, across, down, cv2.INTER_LANCZOS4, borderMode=cv2.BORDER_REPLICATE)
            for f in frames
        ]
        grey = np.clip(np.rint(moved), 0, 255).astype(np.uint8)
        tifffile.imwrite(folder / "frames" / path.name, grey, photometric="minisblack")
    return folder


def by_name(folder):
    return {one.name: one for one in calibrate(read_campaign(folder)).estimates}


@pytest.fixture(scope="module")
def of_plain(plain):
    return by_name(plain)


def test_a_camera_without_fault_shows_none(of_plain):
    assert not [one.name for one in of_plain.values() if one.found]
    scale = of_plain["scale of the front view"]
    assert scale.value == pytest.approx(OPTICS.scale_px_per_m, abs=3 * scale.sigma)
    assert scale.sigma / scale.value < 0.0015


def test_every_estimate_names_an_effect_of_the_catalogue(of_plain):
    assert {one.effect for one in of_plain.values()} <= {effect.name for effect in CATALOGUE}


def test_a_near_camera_is_found_with_its_distance_and_the_smaller_scale_of_the_mirror(tmp_path):
    told = by_name(filmed(tmp_path / "near", replace(OPTICS, distance_m=1 / NEARNESS_PER_M)))
    near, front = told["perspective"], told["scale of the front view"]
    assert near.found
    assert near.value == pytest.approx(NEARNESS_PER_M, abs=3 * near.sigma)
    assert front.value == pytest.approx(OPTICS.scale_px_per_m, abs=3 * front.sigma)
    assert told["scale of the top view"].value < 0.97 * front.value


def test_stretched_rows_are_found_as_pixels_that_are_not_square(tmp_path, plain):
    folder = tmp_path / "stretched"
    folder.mkdir()
    aspect = by_name(stretched(folder, plain, 0.012))["pixel aspect"]
    assert aspect.found
    assert aspect.value == pytest.approx(0.012, abs=3 * aspect.sigma)


def test_a_turned_mirror_is_told_with_its_sign(tmp_path):
    angle = by_name(filmed(tmp_path / "turned", replace(OPTICS, mirror_rad=0.012)))["mirror angle"]
    assert angle.value == pytest.approx(0.012, abs=3 * angle.sigma)
    assert angle.value > 2 * angle.sigma


def test_one_shot_has_larger_errors_than_three(tmp_path, of_plain):
    alone = by_name(filmed(tmp_path / "one", OPTICS, shots=1))
    # Any one of them may come out smaller: three shots tell their scatter to a third of itself.
    ratios = [alone[name].sigma / of_plain[name].sigma for name in alone]
    assert np.median(ratios) > 1.0


def test_a_campaign_without_spheres_is_refused_with_the_reason(tmp_path, plain):
    folder = tmp_path / "empty"
    stretched_frames = folder / "frames"
    stretched_frames.mkdir(parents=True)
    for name in ("campaign.toml", "shots.csv"):
        (folder / name).write_text((plain / name).read_text())
    for shot in (1, 2, 3):
        frames = np.full((8, OPTICS.rows, OPTICS.columns), 33, np.uint8)
        tifffile.imwrite(stretched_frames / f"{shot:04d}.tiff", frames, photometric="minisblack")
    with pytest.raises(InputError, match="no shot can be used"):
        calibrate(read_campaign(folder))
