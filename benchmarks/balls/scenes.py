"""Drawn films of three cameras, each with its own ball, light, ground and drop."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.balls.dropping import GRAVITY, Drop
from benchmarks.balls.filming import Camera, Scene
from benchmarks.balls.tracing import Stage

Floats = NDArray[np.float64]

KINDS = ("12 bits", "8 bits", "telephone")
SIZES = {"12 bits": (224, 128), "8 bits": (320, 144), "telephone": (480, 270)}

ROLL, LEAN = 0.02, 0.007
"""rad: of cameras that stand by eye, and of floors and tables that are laid level."""


def scene(kind: str, seed: int) -> Scene:
    """Return a stage, a drop, a camera and how many frames it films."""
    rng = np.random.default_rng([KINDS.index(kind), seed])
    rows, columns = SIZES[kind]
    diameter = {"12 bits": rng.uniform(0.012, 0.03), "8 bits": rng.uniform(0.025, 0.06)}.get(
        kind, rng.uniform(0.04, 0.08)
    )
    share = {"12 bits": 0.2, "8 bits": 0.15}.get(kind, 0.06) * rng.uniform(0.8, 1.3)
    scale = share * rows / diameter
    distance = {"12 bits": rng.uniform(0.6, 1.4), "8 bits": rng.uniform(1.0, 2.0)}.get(
        kind, rng.uniform(1.6, 2.8)
    )
    focal = scale * distance
    height = rows / scale
    look = rng.uniform(0.0, 0.06)
    floor_row = rows * rng.uniform(0.86, 0.92)
    # The floor's line below the ball lies at that row.
    eye_y = distance * np.tan(look) + (floor_row - 0.5 * rows) / scale
    eye = np.array([0.0, eye_y, -distance])
    stage = Stage(
        size=(rows, columns),
        focal_px=focal,
        eye=eye,
        look_down=look,
        lamp=np.array([rng.uniform(-1.5, 1.5), rng.uniform(1.5, 3.0), rng.uniform(-2.5, -1.0)]),
        lamp_size=rng.uniform(0.05, 0.5),
        ambient=rng.uniform(0.2, 0.5),
        ball=_colour(rng, kind),
        gloss=rng.uniform(0.0, 0.4),
        blotches=rng.uniform(0.0, 0.3),
        wall=np.full(3, 0.0),
        wall_other=np.full(3, 0.0),
        check=rng.uniform(1.5, 6.0) * diameter,
        wall_z=rng.uniform(2.0, 6.0) * diameter + 0.1,
        floor=rng.uniform(0.15, 0.6) * rng.uniform(0.6, 1.0, 3),
        grain=rng.uniform(0.0, 0.25),
        boxes=np.zeros((0, 7)),
    )
    stage = _with_wall(stage, rng)
    top = height * rng.uniform(0.72, 0.8)
    thrown = -rng.uniform(0.8, 1.4) * np.sqrt(2 * GRAVITY * top) if kind == "12 bits" else 0.0
    speed = np.sqrt(2 * GRAVITY * top + thrown**2)
    sideways = rng.uniform(-0.04, 0.04) * speed
    start = np.array([-6.0 * sideways * top / speed, top, 0.0])
    start[0] = np.clip(start[0], -0.25 * columns / scale, 0.25 * columns / scale)
    e0 = rng.uniform(0.65, 0.92)
    drop = Drop(
        diameter=diameter,
        mass=rng.uniform(300, 1500) * np.pi / 6 * diameter**3,
        drag_coefficient=rng.normal(0.47, 0.03),
        start=start,
        speed=np.array([sideways, thrown, rng.uniform(-0.02, 0.02) * speed]),
        restitution=(e0, rng.uniform(0.0, 0.06), 1.0),
        grip=rng.uniform(0.6, 0.9),
    )
    camera, frames = _camera(kind, rng, top, thrown, diameter)
    stage = replace(stage, roll=rng.normal(0.0, ROLL))
    return stage, replace(drop, lean=rng.normal(0.0, LEAN)), camera, frames


def _colour(rng: np.random.Generator, kind: str) -> Floats:
    bright = rng.uniform(0.6, 0.95) if rng.random() < 0.6 else rng.uniform(0.04, 0.12)
    if kind == "telephone":
        return np.asarray(bright * rng.uniform(0.25, 1.0, 3))
    return np.full(3, bright)


def _with_wall(stage: Stage, rng: np.random.Generator) -> Stage:
    # A wall that a person can tell from the ball.
    ball = float(stage.ball.mean())
    tone = rng.uniform(0.08, 0.3) if ball > 0.35 else rng.uniform(0.45, 0.8)
    wall = tone * rng.uniform(0.85, 1.0, 3)
    count = int(rng.integers(0, 4))
    boxes = np.zeros((count, 7))
    for box in boxes:
        box[:2] = rng.uniform(-0.3, 0.3), rng.uniform(0.0, 0.6)
        box[2:4] = rng.uniform(0.01, 0.1, 2)
        box[4:] = tone * rng.uniform(0.5, 1.3, 3)
    values = {name: getattr(stage, name) for name in stage.__slots__}
    values |= {"wall": wall, "wall_other": wall * rng.uniform(0.8, 1.0), "boxes": boxes}
    return Stage(**values)


def _camera(
    kind: str, rng: np.random.Generator, top: float, thrown: float, diameter: float
) -> tuple[Camera, int]:
    blur = rng.uniform(0.4, 0.9)
    fall = float(thrown + np.sqrt(thrown**2 + 2 * GRAVITY * (top - 0.5 * diameter))) / GRAVITY
    if kind == "12 bits":
        rate = 1000.0
        return Camera(rate, 2e-4, 0.0, kind, rng.uniform(6e3, 3e4), 8.0, blur), int(
            rate * (1.0 if thrown == 0 else 2.2) * fall
        )
    if kind == "8 bits":
        rate = 240.0
        exposure = rng.uniform(5e-4, 3.5e-3)
        return Camera(rate, exposure, 0.0, kind, rng.uniform(5e3, 2e4), 8.0, blur), int(
            rate * 3.4 * fall
        )
    rate = 60.0
    exposure, readout = rng.uniform(2e-3, 9e-3), rng.uniform(6e-3, 15e-3)
    return Camera(rate, exposure, readout, kind, rng.uniform(3e3, 1.5e4), 6.0, blur), int(
        rate * 4.5 * fall
    )
