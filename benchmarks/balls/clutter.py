"""Drawn pictures of several balls on clutter: grounds, foregrounds, and balls by ray tracing.

The ground is drawn flat (noise of all sizes, lines, polygons, letters), the balls are traced one by
one and laid over it by their own coverage: strobed, smeared, spotted, partly hidden, overlapping.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.balls.tracing import Stage, trace

Floats = NDArray[np.float64]
Drawn = NDArray[np.uint8]

SIZE = (384, 512)
FOCAL, DISTANCE = 1500.0, 1.5
BLACK = np.zeros(3)


@dataclass(frozen=True, slots=True)
class Seen:
    """A drawn ball: row, column and radius in pixels; share of its outline that shows."""

    row: float
    column: float
    radius: float
    outline: float = 1.0


@dataclass(frozen=True, slots=True)
class Kind:
    """What is drawn.

    Attributes
    ----------
    balls
        Least and most of them.
    radii
        Smallest and largest radius, px.
    spots
        Depth of spots.
    smear
        Way during the exposure in radii.
    strobe
        Exposures of one ball in a picture.
    hidden
        Share of the diameter behind something, at most.
    """

    balls: tuple[int, int] = (1, 3)
    radii: tuple[float, float] = (12.0, 55.0)
    spots: float = 0.0
    smear: float = 0.0
    strobe: int = 1
    hidden: float = 0.0


KINDS = {
    "at rest": Kind(),
    "spotted": Kind(spots=0.85, radii=(18.0, 60.0)),
    "strobed": Kind(balls=(1, 1), radii=(14.0, 30.0), strobe=5),
    "smeared": Kind(smear=0.35),
    "partly hidden": Kind(hidden=0.3, radii=(18.0, 55.0)),
    "many": Kind(balls=(6, 12), radii=(9.0, 26.0)),
}


def ground(rng: np.random.Generator, size: tuple[int, int] = SIZE) -> Floats:
    """Return a cluttered ground without anything round, light of three colours."""
    rows, columns = size
    tone = rng.uniform(0.1, 0.6)
    picture = np.full((rows, columns, 3), tone) * rng.uniform(0.8, 1.2, 3)
    for width in (40.0, 12.0, 3.0):
        noise = cv2.GaussianBlur(rng.standard_normal((rows, columns, 1)), (0, 0), width)
        noise = np.asarray(noise).reshape(rows, columns, 1)
        picture *= 1.0 + rng.uniform(0.03, 0.15) * noise / noise.std()
    return _drawn_over(np.clip(picture, 0.01, 1.0), rng)


def _drawn_over(picture: Floats, rng: np.random.Generator) -> Floats:
    """Draw polygons, lines and letters over a ground."""
    rows, columns = picture.shape[:2]
    # OpenCV writes letters into pictures of 8 bits alone.
    flat = np.zeros((rows, columns, 4), np.uint8)
    for _ in range(int(rng.integers(3, 12))):
        colour = (*(255 * rng.uniform(0.05, 0.8, 3)).astype(int).tolist(), 255)
        middle = rng.uniform((0, 0), (columns, rows))
        corners = middle + rng.uniform(-0.15, 0.15, (int(rng.integers(3, 5)), 2)) * columns
        if rng.random() < 0.6:
            cv2.fillPoly(flat, [np.rint(corners).astype(np.int32)], colour, cv2.LINE_AA)
        else:
            ends = [tuple(int(v) for v in end) for end in corners[:2] * 2 - middle]
            cv2.line(flat, ends[0], ends[1], colour, int(rng.integers(1, 7)), cv2.LINE_AA)
    place = tuple(int(v) for v in rng.uniform((0, 40), (0.7 * columns, rows)))
    scale = float(rng.uniform(0.6, 2.0))
    font = cv2.FONT_HERSHEY_DUPLEX
    cv2.putText(flat, "WALK 47", place, font, scale, (20, 20, 20, 255), 2)
    share = flat[..., 3:] / 255.0
    return np.asarray((1 - share) * picture + share * flat[..., :3] / 255.0)


def stage(rng: np.random.Generator, spots: float, colour: Floats, turn: float = 0.0) -> Stage:
    """Return a camera that looks at nothing but a ball."""
    return Stage(
        size=SIZE,
        focal_px=FOCAL,
        eye=np.array([0.0, 0.0, -DISTANCE]),
        look_down=0.0,
        lamp=np.array([rng.uniform(-2, 2), rng.uniform(1, 3), rng.uniform(-3, -1)]),
        lamp_size=rng.uniform(0.05, 0.6),
        ambient=rng.uniform(0.3, 0.6),
        ball=colour,
        gloss=rng.uniform(0.0, 0.5),
        blotches=rng.uniform(0.0, 0.3),
        wall=BLACK,
        wall_other=BLACK,
        check=1.0,
        wall_z=50.0,
        floor=BLACK,
        grain=0.0,
        boxes=np.zeros((0, 7)),
        spots=spots,
        turn=turn,
    )


def traced(scene: Stage, seen: Seen, way: tuple[float, float], seed: int) -> tuple[Floats, Floats]:
    """Return a ball's light on black and its coverage, shapes (rows, columns, 3) and (.., 1).

    Parameters
    ----------
    way
        Rows and columns that it goes during the exposure.
    """
    reach = int(np.ceil(seen.radius + np.hypot(*way) + 3))
    corner = np.rint([seen.row, seen.column]).astype(int) - reach
    share = np.linspace(-0.5, 0.5, 64)[:, None]
    off = np.array([seen.row, seen.column]) - corner - reach + share * np.array(way)
    ways = np.full((64, 5), seen.radius / FOCAL * DISTANCE)
    ways[:, 0], ways[:, 1] = off[:, 1] * DISTANCE / FOCAL, -off[:, 0] * DISTANCE / FOCAL
    ways[:, 2] = 0.0
    ways[:, 4] = seed
    own = {name: getattr(scene, name) for name in scene.__slots__}
    own |= {"size": (2 * reach + 1, 2 * reach + 1)}
    white = {"ball": np.ones(3), "gloss": 0.0, "blotches": 0.0, "spots": 0.0, "ambient": 1.0}
    light, cover = (_window(Stage(**each), ways, corner) for each in (own, own | white))
    return light, np.minimum(cover[..., :1], 1.0)


def _window(scene: Stage, ways: Floats, corner: NDArray[np.intp]) -> Floats:
    """Return a traced window in a black picture of the whole size."""
    side = scene.size[0]
    light = np.zeros((side, side, 3))
    every = np.ones((side, side), dtype=bool)
    trace(scene.numbers(), scene.boxes, (ways, np.zeros(side)), every, light)
    low = np.maximum(corner, 0)
    high = np.minimum(corner + side, SIZE)
    whole = np.zeros((*SIZE, 3))
    a, b = low - corner, high - corner
    whole[low[0] : high[0], low[1] : high[1]] = light[a[0] : b[0], a[1] : b[1]]
    return whole


def picture(kind: Kind, seed: int) -> tuple[Drawn, list[Seen]]:
    """Return a picture of 8 bits in colour and the balls that are in it."""
    rng = np.random.default_rng([list(KINDS.values()).index(kind), seed])
    flat = ground(rng)
    balls = _strobed(kind, rng) if kind.strobe > 1 else _placed(kind, rng)
    light = flat.copy()
    colour = _colour(rng, flat)
    layers = np.zeros_like(flat)
    for k, ball in enumerate(balls):
        own = colour if kind.strobe > 1 else _colour(rng, flat)
        angle = rng.uniform(0, 2 * np.pi)
        way = kind.smear * rng.uniform(0.5, 1.0) * ball.radius
        scene = stage(rng, kind.spots, own, rng.uniform(0, 6))
        own_light, cover = traced(scene, ball, (way * np.sin(angle), way * np.cos(angle)), seed + k)
        if kind.strobe > 1:
            layers += (own_light - cover * flat) / kind.strobe**0.5
        else:
            light = light * (1 - cover) + own_light
    light += layers
    if kind.hidden:
        open_to_view = np.ones(SIZE, dtype=bool)
        for ball in balls:
            front = _hide(light, ball, kind.hidden * rng.uniform(0.3, 1.0), rng)
            open_to_view[front] = False
        balls = [replace(ball, outline=_outline(ball, open_to_view)) for ball in balls]
    blurred = cv2.GaussianBlur(np.maximum(light, 0.0), (0, 0), rng.uniform(0.4, 1.0))
    noisy = 230 * np.asarray(blurred) + rng.uniform(0.5, 4.0) * rng.standard_normal(light.shape)
    shown: Drawn = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    if rng.random() < 0.5:
        quality = [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(70, 95))]
        shown = np.asarray(cv2.imdecode(cv2.imencode(".jpg", shown, quality)[1], 1), np.uint8)
    return shown, balls


def _colour(rng: np.random.Generator, flat: Floats) -> Floats:
    """Return a colour that a person tells from the ground."""
    tone = flat.mean()
    bright = rng.uniform(0.75, 1.0) if tone < 0.4 else rng.uniform(0.03, 0.12)
    return np.asarray(bright * rng.uniform(0.6, 1.0, 3))


def _placed(kind: Kind, rng: np.random.Generator) -> list[Seen]:
    wanted = int(rng.integers(kind.balls[0], kind.balls[1] + 1))
    balls: list[Seen] = []
    for _ in range(400):
        radius = float(np.exp(rng.uniform(*np.log(kind.radii))))
        place = rng.uniform((radius, radius), np.array(SIZE) - radius)
        apart = [np.hypot(*(place - (b.row, b.column))) / (radius + b.radius) for b in balls]
        if min(apart, default=2.0) > 0.85 and len(balls) < wanted:
            balls.append(Seen(float(place[0]), float(place[1]), radius))
    return balls


def _strobed(kind: Kind, rng: np.random.Generator) -> list[Seen]:
    """Return one ball at equal times of its flight."""
    radius = float(rng.uniform(*kind.radii))
    step = rng.uniform(1.6, 3.2) * radius
    bend = rng.uniform(0.1, 0.5) * radius
    row = rng.uniform(0.2, 0.4) * SIZE[0]
    left = rng.uniform(0.1, 0.25) * SIZE[1]
    times = np.arange(kind.strobe)
    rows = row + bend * (times - rng.uniform(0, 3)) ** 2
    columns = left + step * times
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    inside = [(r, c) for r, c in pairs if radius < r < SIZE[0] - radius and c < SIZE[1] - radius]
    return [Seen(r, c, radius) for r, c in inside]


def _hide(light: Floats, ball: Seen, share: float, rng: np.random.Generator) -> tuple[slice, slice]:
    """Put something with a straight rim in front of part of a ball, and return where it is."""
    edge = ball.row + ball.radius * (1 - 2 * share)
    low, high = round(ball.column - 1.6 * ball.radius), round(ball.column + 1.5 * ball.radius)
    cover = (slice(round(edge), round(edge + 2.5 * ball.radius)), slice(max(0, low), high))
    light[cover] = rng.uniform(0, 0.7, 3)
    return cover


def _outline(ball: Seen, open_to_view: NDArray[np.bool_]) -> float:
    """Return the share of a ball's outline that nothing hides; outside the picture it is hidden."""
    turns = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    rows = np.rint(ball.row + ball.radius * np.sin(turns)).astype(int)
    columns = np.rint(ball.column + ball.radius * np.cos(turns)).astype(int)
    inside = (rows >= 0) & (rows < SIZE[0]) & (columns >= 0) & (columns < SIZE[1])
    return float(open_to_view[rows[inside], columns[inside]].sum() / len(turns))
