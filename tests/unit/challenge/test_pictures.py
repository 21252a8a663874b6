from __future__ import annotations

import csv
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import tifffile
from numpy.typing import NDArray

from simulators.challenge import HIDDEN, write_challenge
from simulators.challenge.camera import OPTICS, apparent
from simulators.challenge.campaign import Fired, fire
from simulators.challenge.effects import switched
from simulators.challenge.nature import Nature
from simulators.challenge.pictures import filmed, sources

Floats = NDArray[np.float64]

SEED, FRAMES = 3, 20
FAR = [0, 1, 18, 19]
"""Frames that show the spheres well apart."""
QUIET_PX = 0.1
"""By markers, noise, and a lens that swells the outer side of a disc."""
OF_THE_CAMERA = (
    *("image-scale", "pixel-aspect", "mirror-angle", "camera-roll", "radial-distortion"),
    "camera-vibration",
)


@cache
def shot(nature: Nature) -> tuple[Fired, NDArray[np.uint8]]:
    fired = fire(nature, SEED, shots=1, frames=FRAMES, pressures_kpa=(20.0, 20.0))
    return fired, next(filmed(fired, nature, OPTICS, SEED))


def moved(nature: Nature) -> tuple[Floats, Floats]:
    """Return by how much four discs lie elsewhere than with an honest camera, px, (F, 2, 2, 2).

    As the pictures have it, by the centres of brightness, and as `apparent` foretells it: rows
    and columns in the front view, rows alone (the column twice) in the mirror.
    """
    fired, plain = shot(Nature())
    _, changed = shot(nature)
    times = np.broadcast_to(fired.times_s, (1, FRAMES))
    true = fired.way.centres
    seen = apparent(true, times, nature, OPTICS)[0]
    found, foretold = np.zeros((FRAMES, 2, 3)), np.zeros((FRAMES, 2, 3))
    for k in FAR:
        for i in range(2):
            x, y, z = true[0, k, i] * OPTICS.scale_px_per_m
            for at, view in ((224.0 + x, slice(0, 2)), (64.0 - z, slice(2, 3))):
                by = brightness(changed[k], at, 200.0 + y) - brightness(plain[k], at, 200.0 + y)
                found[k, i, view] = by[: view.stop - view.start]
    shift = (seen - true[0]) * OPTICS.scale_px_per_m
    foretold[..., :2], foretold[..., 2] = shift[..., :2], -shift[..., 2]
    return found, foretold


def brightness(frame: NDArray[np.uint8], row: float, column: float) -> Floats:
    """Return the centre of what is brighter than the background about a place, px."""
    rows = slice(max(round(row) - 27, 0), round(row) + 28)
    columns = slice(max(round(column) - 27, 0), round(column) + 28)
    bright = frame[rows, columns] > 52
    place = np.argwhere(bright)
    return np.asarray(place.mean(axis=0) + np.array([rows.start, columns.start]))


@pytest.mark.parametrize(
    "name",
    [OF_THE_CAMERA[0], *(pytest.param(name, marks=pytest.mark.long) for name in OF_THE_CAMERA[1:])],
)
def test_pictures_show_each_disc_where_the_poses_say_it_is_seen(name: str) -> None:
    found, foretold = moved(switched({name: 2.0 * HIDDEN[name].amplitude}))
    assert np.abs(foretold[FAR]).max() > 0.1
    np.testing.assert_allclose(found[FAR], foretold[FAR], atol=3.0 * QUIET_PX)
    assert np.abs((found - foretold)[FAR].mean(axis=(0, 1))).max() < 1.5 * QUIET_PX


def test_every_pixel_is_filled_from_where_the_lens_takes_its_light() -> None:
    nature = Nature(roll_rad=0.03, distortion=0.03, pixel_aspect=0.02)
    rows, columns = sources(nature, OPTICS, 0.5)
    down, across = rows - 159.5, columns - 199.5
    radial = 1.0 + 0.03 * (down**2 + across**2) / (159.5**2 + 199.5**2)
    turned = np.exp(-0.03j) * radial * (across + 1j * down)
    there = np.mgrid[:320, :400]
    np.testing.assert_allclose(1.02 * -(-turned).imag + 160.0, there[0], atol=1e-6)
    np.testing.assert_allclose(turned.real + 199.5, there[1], atol=1e-6)


def test_a_seed_gives_the_same_frames_and_natures_share_markers_and_noise() -> None:
    (_, first), (_, again) = shot(Nature()), shot.__wrapped__(Nature())
    np.testing.assert_array_equal(first, again)
    _, other = shot(Nature(restitution=0.5))
    np.testing.assert_array_equal(first[:10], other[:10])
    assert (first[11:] != other[11:]).any(axis=(1, 2)).all()


def test_a_challenge_in_frames_holds_no_poses_and_the_seal_of_the_same_label(
    tmp_path: Path,
) -> None:
    for name, from_frames in (("poses", False), ("frames", True)):
        folder = tmp_path / name
        write_challenge(folder, {"drag": 0.45}, seed=2, shots=3, from_frames=from_frames)
    frames = tmp_path / "frames"
    assert sorted(path.name for path in frames.iterdir()) == [
        *("campaign.toml", "challenge.json", "frames", "sealed.txt", "shots.csv")
    ]
    assert tifffile.imread(frames / "frames/0003.tiff").shape == (24, 320, 400)
    sealed = [(tmp_path / name / "sealed.txt").read_bytes() for name in ("poses", "frames")]
    assert sealed[0] == sealed[1]
    # Nothing is smeared, and no frame shows a contact while it lasts.
    listed = csv.DictReader((frames / "shots.csv").read_text(encoding="utf-8").splitlines())
    assert [float(row["exposure_us"]) for row in listed] == [0.0, 0.0, 0.0]
    assert "exposure_us" not in (tmp_path / "poses" / "shots.csv").read_text(encoding="utf-8")
