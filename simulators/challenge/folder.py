"""A campaign as an exchange folder: what its laboratory hands over."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import tifffile
from numpy.typing import NDArray

from simulators.challenge.camera import OPTICS
from simulators.challenge.campaign import FRAME_RATE_HZ, Campaign
from simulators.challenge.launch import Settings
from simulators.world.description import WorldDescription
from simulators.world.exchange import campaign_toml

_POSES = (
    *("shot", "frame", "t_s", "sphere", "x_m", "y_m", "z_m"),
    *("sigma_x_m", "sigma_y_m", "sigma_z_m", "qw", "qx", "qy", "qz", "sigma_rot_rad"),
)
_SHOTS = ("shot", "time", "pressure_a_kpa", "pressure_b_kpa", "offset_mm", "temperature_c")
_EXPOSURE, _FLASH_US = "exposure_us", 0.0
"""A flash shows one instant."""
_FIRST_SHOT = datetime(2026, 1, 1, 9, tzinfo=UTC)


def write_folder(folder: Path, campaign: Campaign) -> None:
    """Write campaign.toml, shots.csv and poses.csv; the folder is made if it is not there.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    _describe(folder)
    _write(folder / "shots.csv", _SHOTS, _shots(campaign.settings))
    _write(folder / "poses.csv", _POSES, _poses(campaign))


def write_frames(folder: Path, settings: Settings, shots: Iterable[NDArray[np.uint8]]) -> None:
    """Write campaign.toml, shots.csv and the frames (F, rows, columns) of each shot.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    _describe(folder)
    rows = ([*row, _FLASH_US] for row in _shots(settings))
    _write(folder / "shots.csv", (*_SHOTS, _EXPOSURE), rows)
    (folder / "frames").mkdir()
    for shot, frames in enumerate(shots, start=1):
        path = folder / "frames" / f"{shot:04d}.tiff"
        tifffile.imwrite(path, frames, photometric="minisblack", metadata=None, compression="zlib")


def _describe(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    description = campaign_toml(folder.name, WorldDescription(optics=OPTICS), FRAME_RATE_HZ)
    (folder / "campaign.toml").write_text(description, encoding="utf-8")


def _write(path: Path, names: Iterable[str], rows: Iterable[Iterable[object]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows(rows)


def _shots(settings: Settings) -> Iterator[list[object]]:
    noted = zip(
        settings.pressure_kpa.tolist(),
        settings.offset_mm.tolist(),
        settings.temperature_c.tolist(),
        strict=True,
    )
    for shot, (pressure, offset, temperature) in enumerate(noted, start=1):
        time = _FIRST_SHOT + timedelta(minutes=shot - 1)
        stamp = time.strftime("%Y-%m-%dT%H:%M:%SZ")
        yield [shot, stamp, pressure, pressure, offset, temperature]


def _poses(campaign: Campaign) -> Iterator[list[object]]:
    sigma = [campaign.centre_sigma_m] * 3
    times = campaign.times_s.tolist()
    for shot, (centres, turned) in enumerate(
        zip(campaign.centres.tolist(), campaign.orientations.tolist(), strict=True), start=1
    ):
        for frame, time in enumerate(times):
            for i, sphere in enumerate("ab"):
                place = [*centres[frame][i], *sigma]
                spread = campaign.rotation_sigma_rad
                yield [shot, frame, time, sphere, *place, *turned[frame][i], spread]
