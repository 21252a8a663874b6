"""What real films have beside a ball, a wall and a floor: codecs, light that changes, hands.

Each world is a telephone's film of a scene of `scenes`, changed in one way: at 60 frames a second
for even seeds, at 240 for odd ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.balls.filming import Scene, World
from benchmarks.balls.scenes import scene
from benchmarks.balls.tracing import Stage

Floats = NDArray[np.float64]

FAST_HZ = 240.0
SKIN = np.array([0.55, 0.35, 0.27])


@dataclass(frozen=True, slots=True, eq=False)
class Hand:
    """Two fingers and a palm that hold a ball from above, and open.

    Attributes
    ----------
    row, column, radius
        Of the ball that it holds, px.
    grip
        How far the fingers reach over its rim, in radii.
    held_s
        When it lets the ball go.
    opens
        Speed of the fingers, radii/s.
    """

    row: float
    column: float
    radius: float
    grip: float
    held_s: float
    opens: float

    def lay(self, light: Floats, time_s: float) -> None:
        """Draw the hand over a picture's light, linear, shape (rows, columns, 3)."""
        gone = max(0.0, time_s - self.held_s) * self.opens
        mask = np.zeros(light.shape[:2], np.uint8)
        for side in (-1.0, 1.0):
            away = self.column + side * (1.35 - self.grip + min(gone, 1.5)) * self.radius
            row = self.row - (0.7 + 0.6 * gone) * self.radius
            axes = (0.35 * self.radius, 1.1 * self.radius)
            cv2.ellipse(mask, _box((row, away), axes, -12.0 * side), (255.0,), -1, cv2.LINE_AA)
        palm = (self.row - (2.3 + 0.6 * gone) * self.radius, self.column)
        cv2.ellipse(mask, _box(palm, (1.9 * self.radius, self.radius), 0.0), (255.0,), -1)
        share = mask[..., None] / 255.0
        light[:] = (1 - share) * light + share * SKIN


def _box(
    place: tuple[float, float], axes: tuple[float, float], turned: float
) -> tuple[tuple[float, float], tuple[float, float], float]:
    return (place[1], place[0]), (2 * axes[0], 2 * axes[1]), turned


def _coded(rng: np.random.Generator) -> World:
    return World(codec="h264", quality=int(rng.integers(21, 29)))


def _h264(drawn: Scene, rng: np.random.Generator) -> tuple[Scene, World]:
    return drawn, replace(_coded(rng), sharpen=rng.uniform(0.3, 0.9))


def _exposed(drawn: Scene, rng: np.random.Generator) -> tuple[Scene, World]:
    """Let the telephone change its exposure while the ball flies."""
    lasts = drawn[3] / drawn[2].rate_hz
    change = rng.choice([-1.0, 1.0]) * rng.uniform(0.08, 0.25)
    gain = (float(change), rng.uniform(0.1, 0.5) * lasts, rng.uniform(0.1, 0.4) * lasts)
    return drawn, replace(_coded(rng), gain=gain)


def _seamed(drawn: Scene, rng: np.random.Generator) -> tuple[Scene, World]:
    stage, drop, camera, frames = drawn
    stage = replace(stage, seams=rng.uniform(0.5, 0.8), logo=rng.uniform(0.5, 0.9))
    stage = replace(stage, turn=rng.uniform(0, 6))
    return (stage, drop, camera, frames), replace(_coded(rng), spin=rng.uniform(-12.0, 12.0))


def _white(drawn: Scene, rng: np.random.Generator) -> tuple[Scene, World]:
    stage, drop, camera, frames = drawn
    tone = rng.uniform(0.6, 0.75) * rng.uniform(0.95, 1.0, 3)
    ball = rng.uniform(0.88, 0.96) * rng.uniform(0.97, 1.0, 3)
    stage = replace(stage, ball=ball, wall=tone, wall_other=0.95 * tone, boxes=np.zeros((0, 7)))
    return (stage, drop, camera, frames), _coded(rng)


def _from_above(stage: Stage, look: float) -> Stage:
    """Let the camera look down more steeply at the same row of the floor."""
    higher = -stage.eye[2] * (np.tan(look) - np.tan(stage.look_down))
    eye = stage.eye + np.array([0.0, higher, 0.0])
    return replace(stage, eye=eye, look_down=look)


def _nearing(drawn: Scene, rng: np.random.Generator) -> tuple[Scene, World]:
    """Let the ball come nearer far faster than it crosses the picture, filmed from above."""
    stage, drop, camera, frames = drawn
    speed = drop.speed.copy()
    speed[2] = -rng.uniform(0.25, 0.45)
    stage = _from_above(stage, rng.uniform(0.12, 0.25))
    return (stage, replace(drop, speed=speed), camera, frames), _coded(rng)


def _leaning(drawn: Scene, rng: np.random.Generator) -> tuple[Scene, World]:
    """Let the plate lean, and the camera with it: the ball falls aslant in the picture.

    Two bounces show it. Of films with one e is that of a level plate, and off.
    """
    stage, drop, camera, frames = drawn
    lean = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.03, 0.09))
    return (stage, replace(drop, lean=lean), camera, frames), _coded(rng)


def _two_grounds(drawn: Scene, rng: np.random.Generator) -> tuple[Scene, World]:
    """Let the ball fly before a wall as bright as it is, and bounce before a dark table."""
    stage, drop, camera, frames = drawn
    tone = rng.uniform(0.45, 0.6) * rng.uniform(0.95, 1.0, 3)
    ball = rng.uniform(0.85, 0.95) * rng.uniform(0.97, 1.0, 3)
    if rng.random() < 0.4:
        ball *= np.array([1.0, rng.uniform(0.35, 0.45), rng.uniform(0.03, 0.08)])
    floor = rng.uniform(0.06, 0.2) * np.array([1.0, rng.uniform(0.6, 0.9), rng.uniform(0.4, 0.8)])
    stage = replace(
        _from_above(stage, rng.uniform(0.12, 0.25)),
        ball=ball,
        wall=tone,
        wall_other=0.97 * tone,
        floor=floor,
        boxes=np.zeros((0, 7)),
        wall_z=rng.uniform(2.0, 4.0) * drop.diameter,
    )
    return (stage, drop, camera, frames), _coded(rng)


def _spotted(drawn: Scene, rng: np.random.Generator) -> tuple[Scene, World]:
    """Let a light ball with dark patches turn before a wall that is between the two."""
    stage, drop, camera, frames = drawn
    tone = rng.uniform(0.12, 0.4) * rng.uniform(0.85, 1.0, 3)
    ball = rng.uniform(0.75, 0.95) * rng.uniform(0.95, 1.0, 3)
    depth, football = rng.uniform(0.85, 0.97), bool(rng.random() < 0.6)
    stage = replace(
        stage,
        ball=ball,
        caps=football * depth,
        spots=(not football) * depth,
        turn=rng.uniform(0.0, 6.0),
        wall=tone,
        wall_other=rng.uniform(0.8, 1.0) * tone,
    )
    spin = rng.choice([-1.0, 1.0]) * rng.uniform(2.0, 12.0)
    return (stage, drop, camera, frames), replace(_coded(rng), spin=float(spin))


def _held(drawn: Scene, rng: np.random.Generator) -> tuple[Scene, World]:
    stage, drop, camera, frames = drawn
    held_s = rng.uniform(0.15, 0.5)
    row, column = stage.seen(drop.start).tolist()
    radius = stage.radius_px(drop.start, 0.5 * drop.diameter)
    hand = Hand(row, column, radius, rng.uniform(0.1, 0.5), held_s, rng.uniform(10.0, 25.0))
    return (stage, drop, camera, frames + round(held_s * camera.rate_hz)), replace(
        _coded(rng), held_s=held_s, over=hand.lay
    )


def _shadowed(drawn: Scene, rng: np.random.Generator) -> tuple[Scene, World]:
    """Let a small lamp throw a hard shadow on a near wall."""
    stage, drop, camera, frames = drawn
    lamp = np.array([rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 1.5), rng.uniform(0.8, 1.8), -1.5])
    near = rng.uniform(1.2, 2.2) * drop.diameter
    stage = replace(stage, lamp=lamp, lamp_size=0.05, ambient=rng.uniform(0.1, 0.25), wall_z=near)
    return (stage, drop, camera, frames), _coded(rng)


WORLDS = {
    "h264": _h264,
    "auto exposure": _exposed,
    "seams": _seamed,
    "white on bright": _white,
    "hand": _held,
    "shadows": _shadowed,
    "two grounds": _two_grounds,
    "spotted": _spotted,
    "nearing": _nearing,
    "leaning": _leaning,
}


def world(name: str, seed: int) -> tuple[Scene, World]:
    """Return a scene and what its film has beside."""
    rng = np.random.default_rng([101, list(WORLDS).index(name), seed])
    stage, drop, camera, frames = scene("telephone", 1000 + 100 * list(WORLDS).index(name) + seed)
    if seed % 2:
        readout, exposure = rng.uniform(2e-3, 3.8e-3), rng.uniform(5e-4, 3e-3)
        frames = round(frames * FAST_HZ / camera.rate_hz)
        camera = replace(camera, rate_hz=FAST_HZ, readout_s=readout, exposure_s=exposure)
    return WORLDS[name]((stage, drop, camera, frames), rng)
