"""Rendered shots with their truth, one by one or as an exchange folder, for tests of analysis."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import NamedTuple

import numpy as np
import tifffile
from numpy.typing import NDArray

from simulators.world.chance import marked_camera, noise_chance, shot_chance
from simulators.world.description import WorldDescription
from simulators.world.encounter import FLIGHT_LASTS_S, Encounter, simulate
from simulators.world.launch import Launch
from simulators.world.render import front_view, top_view
from simulators.world.truth import contact_truth


class RenderedShot(NamedTuple):
    """Frames (N, rows, columns), their mid-exposure times (N,) in s from the first, and the truth.

    The truth holds what `truth.Truth` does, with `contact_time_s` from the first frame, and for
    each frame a pair (a, b) of `centres_front_px`, `centres_top_px` (row, column) and
    `rotation_quaternion`, None for a sphere in its tube.
    """

    frames: NDArray[np.uint8]
    times_s: NDArray[np.float64]
    truth: dict[str, object]


def render_shot(
    description: WorldDescription,
    launch: Launch,
    seed: int,
    frame_rate_hz: float = 1000.0,
    frames: int = 24,
    shot: int = 1,
) -> RenderedShot:
    """Fire one shot and film it, with the contact about the middle of the frames.

    The contact falls at a random phase between two frames. Spheres that miss are filmed about
    the middle of the field. `shot` numbers the shots of one seed, which share their markers.
    """
    rng = shot_chance(seed, shot)
    encounter = simulate(description, launch, rng)
    camera = marked_camera(description, seed)
    first_s = _middle(encounter) - (frames / 2.0 - 1.0 + rng.uniform()) / frame_rate_hz
    times = np.arange(frames) / frame_rate_hz
    pictures = [
        # The noise is that of the shot: its times alone would repeat from shot to shot.
        camera.take(encounter.poses, first_s + time, noise_chance(seed, shot + time))
        for time in times.tolist()
    ]
    spheres = (description.sphere_a, description.sphere_b)
    truth: dict[str, object] = {"shot": shot, **asdict(launch)}
    truth.update(contact_truth(encounter.contact, spheres))
    if encounter.contact is not None:
        truth["contact_time_s"] = float(encounter.contact.times_s[0]) - first_s
    truth.update(_seen(description, encounter, (first_s + times).tolist()))
    return RenderedShot(np.stack(pictures), times, truth)


def write_campaign(
    folder: Path,
    pressures_kpa: Sequence[float],
    offsets_mm: Sequence[float],
    seed: int,
    description: WorldDescription | None = None,
    frame_rate_hz: float = 1000.0,
    frames: int = 24,
) -> None:
    """Write an exchange folder of rendered shots, one for each pressure and offset.

    `campaign.toml`, `shots.csv` and `frames/0001.tiff` on as any laboratory would hand them over,
    and `truth.json` beside them. Both tubes get the same pressure.

    Raises
    ------
    ValueError
        The lists are not of equal length.
    """
    description = description or WorldDescription()
    (folder / "frames").mkdir(parents=True, exist_ok=True)
    truths = []
    rows = []
    for shot, (pressure, offset) in enumerate(zip(pressures_kpa, offsets_mm, strict=True), start=1):
        launch = Launch(pressure, pressure, offset * 1e-3)
        rendered = render_shot(description, launch, seed, frame_rate_hz, frames, shot)
        path = folder / "frames" / f"{shot:04d}.tiff"
        tifffile.imwrite(path, rendered.frames, photometric="minisblack", metadata=None)
        truths.append(rendered.truth)
        time = datetime(2026, 1, 1, 9, tzinfo=UTC) + timedelta(minutes=shot - 1)
        rows.append([shot, time.strftime("%Y-%m-%dT%H:%M:%SZ"), pressure, pressure, offset])
    with (folder / "shots.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["shot", "time", "pressure_a_kpa", "pressure_b_kpa", "offset_mm"])
        writer.writerows(rows)
    (folder / "campaign.toml").write_text(
        _campaign_toml(folder.name, description, frame_rate_hz), encoding="utf-8"
    )
    truth = {"spheres": _marks(description, seed), "shots": truths}
    (folder / "truth.json").write_text(json.dumps(truth), encoding="utf-8")


def _middle(encounter: Encounter) -> float:
    """Return the first touch, or when the spheres of a missed shot are nearest the middle."""
    if encounter.contact is not None:
        return float(encounter.contact.times_s[0])

    def distance(time_s: float) -> float:
        poses = encounter.poses(time_s)
        return sum(1.0 if pose is None else abs(float(pose.centre[1])) for pose in poses)

    return min(np.arange(0.0, FLIGHT_LASTS_S, 1e-3).tolist(), key=distance)


def _seen(
    description: WorldDescription, encounter: Encounter, times_s: Sequence[float]
) -> dict[str, object]:
    poses = [encounter.poses(time) for time in times_s]
    scale = description.optics.scale_px_per_m
    front, top = front_view(description.optics), top_view(description.optics)
    return {
        "centres_front_px": [
            [pose and front.centre_px(pose.centre, scale) for pose in pair] for pair in poses
        ],
        "centres_top_px": [
            [pose and top.centre_px(pose.centre, scale) for pose in pair] for pair in poses
        ],
        "rotation_quaternion": [
            [pose and pose.orientation.tolist() for pose in pair] for pair in poses
        ],
    }


def _marks(description: WorldDescription, seed: int) -> list[dict[str, object]]:
    camera = marked_camera(description, seed)
    spheres = (description.sphere_a, description.sphere_b)
    return [
        {"markers_body": directions.tolist(), "marker_radius_rad": sphere.marker_radius_rad}
        for directions, sphere in zip(camera.markers, spheres, strict=True)
    ]


def _campaign_toml(name: str, description: WorldDescription, frame_rate_hz: float) -> str:
    optics, environment = description.optics, description.environment
    lines = [
        "format = 1",
        f"name = {json.dumps(name)}",
        "[camera]",
        f"frame_rate_hz = {float(frame_rate_hz)!r}",
        f"width_px = {optics.columns}",
        f"height_px = {optics.rows}",
        f"scale_px_per_m = {optics.scale_px_per_m!r}",
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
