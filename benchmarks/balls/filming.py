"""Cameras that film a drawn ball: a fast one of 12 bits, a plain one of 8, a telephone."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.balls.dropping import STEP_S, Bounce, Drop, fly
from benchmarks.balls.tracing import Stage, trace

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Camera:
    """How light becomes numbers.

    Attributes
    ----------
    rate_hz, exposure_s, readout_s
        Frames a second, time the shutter is open, time to read the last row after the first.
    kind
        "12 bits", "8 bits" or "telephone".
    full
        Light of 1 in electrons.
    read
        Noise of reading, electrons.
    blur_px
        Of the lens.
    """

    rate_hz: float
    exposure_s: float
    readout_s: float
    kind: str
    full: float
    read: float
    blur_px: float


Drawn = NDArray[np.uint8] | NDArray[np.uint16]
Scene = tuple[Stage, Drop, Camera, int]
"""With the number of frames."""


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """What a drawn film shows: bounces, and rows, columns and radii of all frames, shape (N, 3)."""

    bounces: list[Bounce]
    seen: Floats


KEPT = "truth.json"


def kept_truth(folder: Path) -> Truth | None:
    """Return the truth of a film that was drawn into this folder before; None where none was."""
    if not (folder / KEPT).exists():
        return None
    told = json.loads((folder / KEPT).read_text())
    return Truth([Bounce(*each) for each in told["bounces"]], np.array(told["seen"]))


def film(folder: Path, scene: Scene, seed: int) -> Truth:
    """Draw a film as a campaign's folder with one shot; one that is there already is kept."""
    kept = kept_truth(folder)
    if kept is not None:
        return kept
    stage, drop, camera, frames = scene
    rng = np.random.default_rng(seed)
    lead = 0.5 * camera.exposure_s
    lasts = frames / camera.rate_hz + camera.exposure_s + camera.readout_s + 0.01
    _, places, bounces = fly(drop, lasts)
    rows, columns = stage.size
    delays = np.linspace(0.0, camera.readout_s, rows) / STEP_S
    pictures, seen = [], []
    for k in range(frames):
        begin = k / camera.rate_hz
        first = round(begin / STEP_S)
        last = round((begin + camera.exposure_s + camera.readout_s) / STEP_S) + 2
        light = np.zeros((rows, columns, 3))
        radius = 0.5 * drop.diameter
        ways = np.full((last - first, 5), radius)
        ways[:, :3] = places[first:last]
        ways[:, 4] = rng.integers(2**31)
        trace(stage.numbers(), stage.boxes, ways, delays, light)
        pictures.append(_picture(light, camera, rng))
        middle = round((begin + lead) / STEP_S)
        row = stage.seen(places[middle])[0]
        own = middle + round(camera.readout_s * row / max(rows - 1, 1) / STEP_S)
        place = places[min(own, len(places) - 1)]
        seen.append([*stage.seen(place), stage.radius_px(place, radius)])
    _write(folder, pictures, drop, camera)
    # Times count from the middle of the first frame's exposure of row 0.
    told = [Bounce(b.time - lead, b.v_n, b.v_n_after) for b in bounces]
    plain = {"bounces": [[b.time, b.v_n, b.v_n_after] for b in told], "seen": seen}
    (folder / KEPT).write_text(json.dumps(plain, default=float))
    return Truth(told, np.array(seen))


def _picture(light: Floats, camera: Camera, rng: np.random.Generator) -> Drawn:
    light = np.asarray(cv2.GaussianBlur(light, (0, 0), camera.blur_px), dtype=np.float64)
    if camera.kind == "telephone":
        electrons = rng.poisson(camera.full * light) + camera.read * rng.standard_normal(
            light.shape
        )
        level = np.clip(electrons / camera.full, 0.0, 1.0)
        curved = np.where(level <= 0.0031308, 12.92 * level, 1.055 * level ** (1 / 2.4) - 0.055)
        return np.asarray(np.rint(255 * curved)[..., ::-1], dtype=np.uint8)
    grey = light @ np.array([0.3, 0.59, 0.11])
    electrons = rng.poisson(camera.full * grey) + camera.read * rng.standard_normal(grey.shape)
    if camera.kind == "12 bits":
        deep = np.rint(electrons * 3900 / camera.full + 64)
        return np.asarray(np.clip(deep, 0, 4095), dtype=np.uint16)
    plain = np.rint(electrons * 240 / camera.full + 4)
    return np.asarray(np.clip(plain, 0, 255), dtype=np.uint8)


def _write(folder: Path, pictures: list[Drawn], drop: Drop, camera: Camera) -> None:
    frames = folder / "frames"
    if camera.kind == "telephone":
        frames.mkdir(parents=True, exist_ok=True)
        code = cv2.VideoWriter.fourcc(*"mp4v")
        size = pictures[0].shape[1::-1]
        video = cv2.VideoWriter(str(frames / "0001.mp4"), code, camera.rate_hz, size)
        for picture in pictures:
            video.write(picture)
        video.release()
    else:
        (frames / "0001").mkdir(parents=True, exist_ok=True)
        for k, picture in enumerate(pictures):
            cv2.imwrite(str(frames / "0001" / f"{k:04d}.png"), picture)
    density = drop.mass / (np.pi / 6 * drop.diameter**3)
    height, width = pictures[0].shape[:2]
    (folder / "campaign.toml").write_text(
        f"format = 1\nname = {json.dumps(folder.name)}\n[camera]\n"
        f"frame_rate_hz = {camera.rate_hz}\nwidth_px = {width}\nheight_px = {height}\n"
        f'[[spheres]]\nname = "a"\ndiameter_m = {drop.diameter}\n'
        f'density_kg_per_m3 = {density}\n[[spheres]]\nname = "b"\nplate = true\n'
        "[environment]\ngravity_m_per_s2 = 9.80665\nair_density_kg_per_m3 = 1.2\n"
    )
    exposure = f"{1e6 * camera.exposure_s:.1f}" if camera.kind == "12 bits" else ""
    (folder / "shots.csv").write_text(f"shot,time,exposure_us\n1,2026-01-31T00:00:00Z,{exposure}\n")
