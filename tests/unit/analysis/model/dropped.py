"""Campaigns of a ball that is thrown onto a plate, as exchange folders of poses."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from simulators.challenge.drops import Body, Drop, film

DESCRIPTION = """\
format = 1
name = "drops"
[camera]
frame_rate_hz = {rate}
width_px = 240
height_px = 400
scale_px_per_m = 1574.8
[[spheres]]
name = "a"
diameter_m = {diameter}
density_kg_per_m3 = {density}
[[spheres]]
name = "b"
plate = true
{plate}
[environment]
{air}
"""
COLUMNS = (
    "shot frame t_s sphere x_m y_m z_m sigma_x_m sigma_y_m sigma_z_m qw qx qy qz sigma_rot_rad"
)
SIGMA_RAD = 2e-3


def write_drops(
    folder: Path,
    drop: Drop,
    *,
    shots: int,
    seed: int,
    heights_m: tuple[float, float] = (0.05, 0.4),
    sideways: float = 0.5,
    spinning: float = 30.0,
    rate_hz: float = 500.0,
    lasts_s: float = 0.6,
    sigma_m: float = 1e-5,
    markers: bool = True,
    air: str = "",
    toward: tuple[float, float] = (0.0, 0.0),
    plate: str = "",
) -> Path:
    """Write a campaign of throws; return its folder.

    Parameters
    ----------
    sideways, spinning
        Scatter of the velocity along the plate, m/s, and of the spin, rad/s, of a throw.
    markers
        Whether orientations are seen, and the third coordinate with them.
    toward
        Least and largest speed of a throw toward the plate, m/s.
    plate
        What the description says of the plate.
    """
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    described = DESCRIPTION.format(
        rate=rate_hz,
        diameter=2 * drop.radius_m,
        density=drop.density_kg_per_m3,
        air=air,
        plate=plate,
    )
    # Into the plate, and two directions along it.
    into = np.array(drop.into) / np.linalg.norm(drop.into)
    axes = np.roll(np.eye(3), -int(np.argmax(np.abs(into))), axis=0)
    axes[0], axes[1] = into, axes[1] - (axes[1] @ into) * into
    axes[1] /= np.linalg.norm(axes[1])
    axes[2] = np.cross(axes[0], axes[1])
    (folder / "campaign.toml").write_text(described, encoding="utf-8")
    numbers = "".join(f"{n}\n" for n in range(1, shots + 1))
    (folder / "shots.csv").write_text("shot\n" + numbers, encoding="utf-8")
    with (folder / "poses.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS.split())
        for shot in range(1, shots + 1):
            start = Body(
                np.array([-rng.uniform(*heights_m) - drop.radius_m, *rng.normal(0, 0.01, 2)])
                @ axes,
                np.array([rng.uniform(*toward), *rng.normal(0.0, sideways, 2)]) @ axes,
                rng.normal(0.0, spinning, 3),
                Rotation.random(rng=rng),
            )
            times, places, turns = film(drop, start, rate_hz, lasts_s)
            places = places + rng.normal(0.0, sigma_m, places.shape)
            wrong = Rotation.from_rotvec(rng.normal(0.0, SIGMA_RAD, places.shape))
            seen = (wrong * Rotation.from_quat(turns, scalar_first=True)).as_quat(scalar_first=True)
            for k, t in enumerate(times):
                third = places[k, 2] if markers else ""
                place = [*places[k, :2], third, sigma_m, sigma_m, sigma_m if markers else ""]
                turned = [*seen[k], SIGMA_RAD] if markers else [""] * 5
                writer.writerow([shot, k, t, "a", *place, *turned])
    return folder
