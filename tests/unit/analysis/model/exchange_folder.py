"""Poses written as an exchange folder, from the description of its format alone."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from analysis.model.data.poses import PoseData

DESCRIPTION = """\
format = 1
name = "hard spheres"
[camera]
frame_rate_hz = 1000.0
width_px = 240
height_px = 192
scale_px_per_m = 1574.8
front_view_rows = [88, 192]
top_view_rows = [0, 88]
front_origin_px = [132.0, 120.0]
top_origin_px = [46.0, 120.0]
[[spheres]]
name = "a"
diameter_m = 0.0254
density_kg_per_m3 = 1150.0
[[spheres]]
name = "b"
diameter_m = 0.0254
density_kg_per_m3 = 1150.0
"""
POSES = "shot frame t_s sphere x_m y_m z_m sigma_x_m sigma_y_m sigma_z_m qw qx qy qz sigma_rot_rad"


def write_campaign(folder: Path, data: PoseData) -> Path:
    """Write campaign.toml, shots.csv and poses.csv; return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "campaign.toml").write_text(DESCRIPTION, encoding="utf-8")
    lines = ["shot,time", *(f"{n},2026-01-01T09:{n // 60:02}:{n % 60:02}Z" for n in data.shots)]
    (folder / "shots.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    with (folder / "poses.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(POSES.split())
        for s, k, i in np.ndindex(data.rotation_sigma.shape):
            if not np.isfinite(data.position_sigma[s, k, i]).all():
                continue
            turned: list[object] = [""] * 5
            if np.isfinite(data.rotation_sigma[s, k, i]):
                quaternion = Rotation.from_matrix(data.rotation[s, k, i]).as_quat(scalar_first=True)
                turned = [*map(float, quaternion), float(data.rotation_sigma[s, k, i])]
            place = [*data.position[s, k, i], *data.position_sigma[s, k, i]]
            row = [data.shots[s], k, float(data.times_s[s, k]), "ab"[i], *map(float, place)]
            writer.writerow([*row, *turned])
    return folder
