"""An exchange folder of rendered shots, as a laboratory would hand it over, with its truth."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path

import tifffile

from simulators.world.chance import marked_camera
from simulators.world.description import WorldDescription
from simulators.world.launch import Launch
from simulators.world.shots import render_shot

COLUMNS = ("shot", "time", "pressure_a_kpa", "pressure_b_kpa", "offset_mm", "exposure_us")


def write_campaign(
    folder: Path,
    pressures_kpa: Sequence[float],
    offsets_mm: Sequence[float],
    seed: int,
    *,
    description: WorldDescription | None = None,
    frame_rate_hz: float = 1000.0,
    frames: int = 24,
    state_scale: bool = True,
    pressures_b_kpa: Sequence[float] | None = None,
) -> None:
    """Write an exchange folder of rendered shots, one for each pressure and offset.

    `campaign.toml`, `shots.csv` and `frames/0001.tiff` on as any laboratory would hand them over,
    and `truth.json` beside them. Both tubes get the same pressure, unless that of b is given.
    Without `state_scale` the scale is left to be found from the images.

    Raises
    ------
    ValueError
        The lists are not of equal length.
    """
    description = description or WorldDescription()
    (folder / "frames").mkdir(parents=True, exist_ok=True)
    truths = []
    rows = []
    settings = zip(pressures_kpa, pressures_b_kpa or pressures_kpa, offsets_mm, strict=True)
    for shot, (pressure, pressure_b, offset) in enumerate(settings, start=1):
        launch = Launch(pressure, pressure_b, offset * 1e-3)
        rendered = render_shot(
            description, launch, seed, frame_rate_hz=frame_rate_hz, frames=frames, shot=shot
        )
        path = folder / "frames" / f"{shot:04d}.tiff"
        tifffile.imwrite(path, rendered.frames, photometric="minisblack", metadata=None)
        truths.append(rendered.truth)
        time = datetime(2026, 1, 1, 9, tzinfo=UTC) + timedelta(minutes=shot - 1)
        when = time.strftime("%Y-%m-%dT%H:%M:%SZ")
        rows.append([shot, when, pressure, pressure_b, offset, 1e6 * description.optics.exposure_s])
    with (folder / "shots.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)
    (folder / "campaign.toml").write_text(
        campaign_toml(folder.name, description, frame_rate_hz, state_scale=state_scale),
        encoding="utf-8",
    )
    truth = {"spheres": _marks(description, seed), "shots": truths}
    (folder / "truth.json").write_text(json.dumps(truth), encoding="utf-8")


def _marks(description: WorldDescription, seed: int) -> list[dict[str, object]]:
    camera = marked_camera(description, seed)
    spheres = (description.sphere_a, description.sphere_b)
    return [
        {"markers_body": directions.tolist(), "marker_radius_rad": sphere.marker_radius_rad}
        for directions, sphere in zip(camera.markers, spheres, strict=True)
    ]


def campaign_toml(
    name: str, description: WorldDescription, frame_rate_hz: float, *, state_scale: bool = True
) -> str:
    """Return the text of campaign.toml: camera, spheres and surroundings as stated."""
    optics, environment = description.optics, description.environment
    lines = [
        "format = 1",
        f"name = {json.dumps(name)}",
        "[camera]",
        f"frame_rate_hz = {float(frame_rate_hz)!r}",
        f"width_px = {optics.columns}",
        f"height_px = {optics.rows}",
        *([f"scale_px_per_m = {optics.scale_px_per_m!r}"] if state_scale else []),
        f"front_view_rows = {list(optics.front_rows)}",
        f"top_view_rows = {list(optics.top_rows)}",
        f"front_origin_px = {list(optics.front_origin_px)}",
        f"top_origin_px = {list(optics.top_origin_px)}",
    ]
    for sphere_name, sphere in (("a", description.sphere_a), ("b", description.sphere_b)):
        lines += [
            "[[spheres]]",
            f'name = "{sphere_name}"',
            f"diameter_m = {sphere.diameter_m!r}",
            f"density_kg_per_m3 = {sphere.density_kg_per_m3!r}",
            f"inertia_factor = {sphere.inertia_factor!r}",
        ]
    lines += [
        "[environment]",
        f"gravity_m_per_s2 = {environment.gravity_m_per_s2!r}",
        f"air_density_kg_per_m3 = {environment.air_density_kg_per_m3!r}",
    ]
    return "\n".join(lines) + "\n"
