"""Cameras that film a drawn ball: a fast one of 12 bits, a plain one of 8, a telephone."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.balls.coding import sharpened, write_h264, write_mpeg4
from benchmarks.balls.dropping import STEP_S, Bounce, Drop, fly
from benchmarks.balls.tracing import Stage, near_ball, trace

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
class World:
    """What a film has beside ball, wall and floor.

    Attributes
    ----------
    codec, quality
        Of a telephone's film: "mp4v", or "h264" with its constant rate factor.
    sharpen
        By how much edges are made steeper.
    gain
        Relative change of the light, from when and for how long (s): exposure set anew.
    spin
        Of the ball, rad/s.
    held_s
        The ball stays at its start for so long.
    over
        Draws over the light of a picture at a time in s.
    """

    codec: str = "mp4v"
    quality: int = 23
    sharpen: float = 0.0
    gain: tuple[float, float, float] = (0.0, 0.0, 1.0)
    spin: float = 0.0
    held_s: float = 0.0
    over: Callable[[Floats, float], None] | None = None

    def gained(self, time_s: float) -> float:
        """Return the light at a time over that at the start."""
        change, begins, lasts = self.gain
        share = min(1.0, max(0.0, (time_s - begins) / lasts))
        return 1.0 + change * share * share * (3.0 - 2.0 * share)


PLAIN = World()


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """What a drawn film shows: bounces, and rows, columns and radii of all frames, shape (N, 3)."""

    bounces: list[Bounce]
    seen: Floats


KEPT = "truth.json"
ROW_STEPS = 6
"""To when the row is read on which the ball then is: it moves by up to a tenth of what it waits."""
MOST_INSTANTS = 5
"""Of an exposure, at which the pixels are sought that the ball changes."""


def kept_truth(folder: Path) -> Truth | None:
    """Return the truth of a film that was drawn into this folder before; None where none was."""
    if not (folder / KEPT).exists():
        return None
    told = json.loads((folder / KEPT).read_text())
    return Truth([Bounce(*each) for each in told["bounces"]], np.array(told["seen"]))


def film(folder: Path, scene: Scene, seed: int, world: World = PLAIN) -> Truth:
    """Draw a film as a campaign's folder with one shot; one that is there already is kept."""
    kept = kept_truth(folder)
    if kept is not None:
        return kept
    stage, drop, camera, frames = scene
    rng = np.random.default_rng(seed)
    lead = 0.5 * camera.exposure_s
    lasts = frames / camera.rate_hz + camera.exposure_s + camera.readout_s + 0.01
    _, places, bounces = fly(drop, lasts)
    still = round(world.held_s / STEP_S)
    places = np.concatenate([np.tile(drop.start, (still, 1)), places])
    bounces = [replace(b, time=b.time + still * STEP_S) for b in bounces]
    rows = stage.size[0]
    delays = np.linspace(0.0, camera.readout_s, rows) / STEP_S
    pictures, seen = [], []
    still_light = _without_ball(stage, seed)
    for k in range(frames):
        begin = k / camera.rate_hz
        first = round(begin / STEP_S)
        last = round((begin + camera.exposure_s + camera.readout_s) / STEP_S) + 2
        radius = 0.5 * drop.diameter
        ways = np.full((last - first, 5), radius)
        ways[:, :3] = places[first:last]
        ways[:, 4] = rng.integers(2**31)
        turned = replace(stage, turn=stage.turn + world.spin * begin)
        light = _lit(turned, ways, delays, still_light)
        if world.over is not None:
            world.over(light, begin)
        light *= world.gained(begin)
        pictures.append(_picture(light, camera, rng))
        middle = round((begin + lead) / STEP_S)
        place = places[middle]
        for _ in range(ROW_STEPS):
            row = stage.seen(place)[0]
            own = middle + round(camera.readout_s * row / max(rows - 1, 1) / STEP_S)
            place = places[min(own, len(places) - 1)]
        seen.append([*stage.seen(place), stage.radius_px(place, radius)])
    _write(folder, pictures, (drop, camera, world))
    # Times count from the middle of the first frame's exposure of row 0.
    told = [Bounce(b.time - lead, b.v_n, b.v_n_after) for b in bounces]
    plain = {"bounces": [[b.time, b.v_n, b.v_n_after] for b in told], "seen": seen}
    (folder / KEPT).write_text(json.dumps(plain, default=float))
    return Truth(told, np.array(seen))


def _without_ball(stage: Stage, seed: int) -> Floats:
    light, every = np.zeros((*stage.size, 3)), np.ones(stage.size, dtype=bool)
    nothing = np.array([[0.0, 0.0, 0.0, 0.0, seed]])
    trace(stage.numbers(), stage.boxes, (nothing, np.zeros(stage.size[0])), every, light)
    return light


def _lit(stage: Stage, ways: Floats, delays: Floats, still: Floats) -> Floats:
    """Return the light of one exposure; where the ball changes nothing, that of the stage."""
    some = ways[:: max(1, len(ways) // MOST_INSTANTS), :4].copy()
    some[:, 3] += np.abs(np.diff(some[:, :3], axis=0)).sum(axis=1).max(initial=0.0)
    near = np.zeros(stage.size, dtype=bool)
    near_ball(stage.numbers(), some, near)
    wide = cv2.dilate(near.astype(np.uint8), np.ones((7, 7), np.uint8))
    chosen = np.asarray(wide) > 0
    light = np.where(chosen[..., None], 0.0, still)
    trace(stage.numbers(), stage.boxes, (ways, delays), chosen, light)
    return light


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


def _write(folder: Path, pictures: list[Drawn], shown: tuple[Drop, Camera, World]) -> None:
    drop, camera, world = shown
    frames = folder / "frames"
    if camera.kind == "telephone":
        frames.mkdir(parents=True, exist_ok=True)
        path = frames / "0001.mp4"
        own = [sharpened(picture.astype(np.uint8), world.sharpen) for picture in pictures]
        if world.codec == "h264":
            write_h264(path, own, camera.rate_hz, world.quality)
        else:
            write_mpeg4(path, own, camera.rate_hz)
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
