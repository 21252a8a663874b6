"""Frames of more bits, in colour, and of a camera's own file are kept as they came."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from rigctl.exchange.exporting import export_campaign
from rigctl.exchange.importing import Imported
from rigctl.store import Store
from rigctl.store.folders import read_light
from tests.unit.analysis.balls import test_camera_files as cameras
from tests.unit.exchange.conftest import silent

Take = Callable[..., Imported]
SHAPE = 6, 16, 24


def kept(store: Store, campaign: str) -> dict[int, str]:
    shots = store.catalogue.shots(campaign=campaign, limit=9)
    return {shot.imported_as: shot.id for shot in shots if shot.imported_as is not None}


@pytest.fixture
def deep(folder: Path) -> np.ndarray:
    """Shot 7 of the folder has 12 bits in an array file."""
    values = np.random.default_rng(1).integers(0, 4096, SHAPE, dtype=np.uint16)
    values[0, 0, 0] = 4095
    np.save(folder / "frames" / "0007.npy", values)
    return values


def test_all_bits_are_measured_and_pictures_are_rounded(
    store: Store, folder: Path, take: Take, deep: np.ndarray
) -> None:
    shot = kept(store, take(folder).campaign)[7]
    manifest = store.folders.manifest(shot)
    assert manifest["frames"]["dtype"] == "float32"
    assert manifest["exposure_s"] is None
    assert "12 bits" in manifest["frames"]["notes"][0]
    light = read_light(store.folders.folder(shot) / manifest["frames"]["file"])
    np.testing.assert_allclose(light, deep * (255 / 4095), rtol=1e-6)
    shown = store.frames(shot).pixels
    assert shown.dtype == np.uint8
    assert np.abs(shown - light.astype(float)).max() <= 0.5


def test_they_come_out_as_they_went_in(
    store: Store, folder: Path, take: Take, deep: np.ndarray, tmp_path: Path
) -> None:
    export_campaign(store, take(folder).campaign, tmp_path / "out", progress=silent)
    np.testing.assert_array_equal(np.load(tmp_path / "out" / "frames" / "0007.npy"), deep)


def test_of_colour_the_brightness_is_measured(store: Store, folder: Path, take: Take) -> None:
    green = np.zeros((*SHAPE, 3), np.uint8)
    green[..., 1] = 100
    np.save(folder / "frames" / "0007.npy", green)
    shot = kept(store, take(folder).campaign)[7]
    np.testing.assert_allclose(store.frames(shot).pixels, 59)


@pytest.mark.parametrize(("stated", "exposure_s"), [("", 5e-5), ("250", 2.5e-4)])
def test_the_exposure_in_a_cameras_header_is_that_of_its_shot_unless_another_is_stated(
    store: Store, folder: Path, take: Take, stated: str, exposure_s: float
) -> None:
    (folder / "frames" / "0007.npy").unlink()
    (folder / "frames" / "0007.json").unlink()
    values = np.full((cameras.FRAMES, cameras.ROWS, cameras.COLUMNS), 900, np.uint16)
    cameras.write_photron(folder / "frames" / "0007", values, 12)
    (folder / "shots.csv").write_text(f"shot,exposure_us\n3,\n7,{stated}\n12,\n")
    shot = kept(store, take(folder).campaign)[7]
    assert store.folders.manifest(shot)["exposure_s"] == pytest.approx(exposure_s)
