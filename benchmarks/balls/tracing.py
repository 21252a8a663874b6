"""A ray tracer for one ball between a floor and a wall: shares no optics with what measures it.

Metres; x right, y up, z away from the camera.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """Everything but the ball's place.

    Attributes
    ----------
    size
        Rows and columns of the picture.
    focal_px, eye, look_down
        Of a pinhole camera: focal length, place, and angle below the horizontal in rad.
    lamp, lamp_size, ambient
        Place and size of the light, and how much comes from everywhere.
    ball, gloss, blotches
        Colour of the ball (red, green, blue, 0 to 1), strength of its highlight, depth of its
        blotches.
    wall, wall_other, check
        Two colours of the wall, which stands at `wall_z`, and the side of its checks in m.
    floor, grain
        Colour of the floor and depth of its grain.
    boxes
        Clutter: rectangles on the wall, (x, y, half width, half height, red, green, blue).
    spots, turn
        Depth of dark spots with sharp rims on the ball, and by how much it is turned, rad.
    seams, logo
        Depth of two dark seams round the ball, and of a round print on it.
    caps
        Depth of the twelve round patches of a football.
    roll
        Of the camera about its line of sight, rad: what is on the right is seen higher.
    """

    size: tuple[int, int]
    focal_px: float
    eye: Floats
    look_down: float
    lamp: Floats
    lamp_size: float
    ambient: float
    ball: Floats
    gloss: float
    blotches: float
    wall: Floats
    wall_other: Floats
    check: float
    wall_z: float
    floor: Floats
    grain: float
    boxes: Floats
    spots: float = 0.0
    turn: float = 0.0
    seams: float = 0.0
    logo: float = 0.0
    roll: float = 0.0
    caps: float = 0.0

    def numbers(self) -> Floats:
        """Return all but the boxes in one array."""
        plain = [self.focal_px, *self.eye, self.look_down, *self.lamp, self.lamp_size]
        plain += [self.ambient, *self.ball, self.gloss, self.blotches, *self.wall]
        plain += [*self.wall_other, self.check, self.wall_z, *self.floor, self.grain]
        plain += [self.spots, self.turn, self.seams, self.logo, self.roll, self.caps]
        return np.array(plain, dtype=np.float64)

    def seen(self, place: Floats) -> Floats:
        """Return where the camera sees a point: row and column, shape (2,)."""
        x, y, z = place - self.eye
        c, s = math.cos(self.look_down), math.sin(self.look_down)
        ahead, up = c * z - s * y, s * z + c * y
        c, s = math.cos(self.roll), math.sin(self.roll)
        right, up = c * x - s * up, c * up + s * x
        row = 0.5 * (self.size[0] - 1) - self.focal_px * up / ahead
        return np.array([row, 0.5 * (self.size[1] - 1) + self.focal_px * right / ahead])

    def radius_px(self, place: Floats, radius_m: float) -> float:
        """Return a ball's radius in the picture."""
        y, z = (place - self.eye)[1:]
        ahead = math.cos(self.look_down) * z - math.sin(self.look_down) * y
        return float(self.focal_px * radius_m / math.sqrt(ahead**2 - radius_m**2))


FOCAL, EYE, LOOK, LAMP, LAMP_SIZE, AMBIENT, BALL, GLOSS, BLOTCHES = 0, 1, 4, 5, 8, 9, 10, 13, 14
WALL, OTHER, CHECK, WALL_Z, FLOOR, GRAIN = 15, 18, 21, 22, 23, 26
SPOTS, TURN, SEAMS, LOGO, ROLL, CAPS = 27, 28, 29, 30, 31, 32
"""Where the numbers of a stage begin."""
CAP = math.cos(0.36)
"""Cosine of the angle from a cap's middle to its edge."""
FINE = 4
"""Samples of a pixel along each side."""
ORDER = (15, 2, 1, 12, 4, 9, 10, 7, 8, 5, 6, 11, 3, 14, 13, 0)
"""Which part of the exposure each sample sees: a magic square, so that neither rows nor columns of
a pixel are earlier than others."""


@part
def _random(state: NDArray[np.uint64]) -> float:
    """Return the next number between 0 and 1 (xorshift, Marsaglia 2003)."""
    x = state[0]
    x ^= x << np.uint64(13)
    x ^= x >> np.uint64(7)
    x ^= x << np.uint64(17)
    state[0] = x
    return float(x >> np.uint64(11)) / 9007199254740992.0


@part
def _grain(x: float, y: float, k: float) -> float:
    """Return a smooth pattern between -1 and 1."""
    a = math.sin(12.9 * x * k + 3.1) * math.sin(9.7 * y * k + 1.3)
    b = math.sin(31.7 * (x + 0.31 * y) * k) * math.sin(27.1 * (y - 0.43 * x) * k + 2.2)
    return 0.6 * a + 0.4 * b


@part
def _unit(v: Floats) -> float:
    """Make a vector one of length 1; return what its length was."""
    length = math.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
    v /= length
    return length


@part
def _meets(origin: Floats, way: Floats, ball: Floats, radius: float) -> float:
    """Return how far along a ray a ball is met; negative where it is not."""
    to = ball - origin
    along = to[0] * way[0] + to[1] * way[1] + to[2] * way[2]
    gap = radius * radius - (to[0] ** 2 + to[1] ** 2 + to[2] ** 2 - along * along)
    return along - math.sqrt(gap) if gap > 0.0 and along > 0.0 else -1.0


@part
def _capped(x: float, y: float, z: float) -> bool:
    """Return whether a direction is within a cap about a corner of an icosahedron."""
    p = 0.5 * (1.0 + math.sqrt(5.0))
    nearest = max(abs(z * p + y), abs(z * p - y), abs(y * p + x))
    nearest = max(nearest, abs(y * p - x), abs(x * p + z), abs(x * p - z))
    return nearest > CAP * math.sqrt(1.0 + p * p)


@part
def _ball_colour(scene: Floats, normal: Floats, way: Floats, lamp: Floats, colour: Floats) -> None:
    shine = max(0.0, normal[0] * lamp[0] + normal[1] * lamp[1] + normal[2] * lamp[2])
    half = lamp - way
    _unit(half)
    glint = max(0.0, normal[0] * half[0] + normal[1] * half[1] + normal[2] * half[2])
    # Its paint is turned about an axis that leans towards the camera.
    c, s = math.cos(scene[TURN]), math.sin(scene[TURN])
    x, z = c * normal[0] + s * normal[2], c * normal[2] - s * normal[0]
    y, z = 0.9 * normal[1] + 0.436 * z, 0.9 * z - 0.436 * normal[1]
    tone = 1.0 - scene[BLOTCHES] * (0.5 + 0.5 * _grain(x + 0.3, y - 0.2, 0.45))
    if _grain(x + 0.5 * z, y - 0.4 * z, 0.2) > 0.25:
        tone *= 1.0 - scene[SPOTS]
    if _capped(x, y, z):
        tone *= 1.0 - scene[CAPS]
    if abs(y) < 0.05 or abs(x * x - 0.35 - 0.4 * y * y) < 0.05:
        tone *= 1.0 - scene[SEAMS]
    if (x - 0.5) ** 2 + (y - 0.4) ** 2 < 0.09 and z < 0.0:
        tone *= 1.0 - scene[LOGO]
    for k in range(3):
        # Light from the floor lies on its lower half.
        low = 0.25 * scene[FLOOR + k] * (0.5 - 0.5 * normal[1])
        light = scene[AMBIENT] + low + (1 - scene[AMBIENT]) * shine
        colour[k] = scene[BALL + k] * tone * light + scene[GLOSS] * glint**40


@part
def _ground_colour(scene: Floats, boxes: Floats, point: Floats, on_floor: bool, c: Floats) -> None:
    x, y, z = point
    if on_floor:
        c[:] = scene[FLOOR : FLOOR + 3] * (1.0 + scene[GRAIN] * _grain(x, 3 * z, 7.0))
        return
    odd = int(math.floor(x / scene[CHECK]) + math.floor(y / scene[CHECK])) % 2
    first = OTHER if odd else WALL
    c[:] = scene[first : first + 3] * (1.0 + 0.3 * scene[GRAIN] * _grain(x, y, 5.0))
    for box in boxes:
        if abs(x - box[0]) < box[2] and abs(y - box[1]) < box[3]:
            c[:] = box[4:]


@part
def _apart(origin: Floats, way: Floats, ball: Floats) -> tuple[float, float]:
    """Return how far a point lies along a ray, and how far beside it."""
    x, y, z = ball[0] - origin[0], ball[1] - origin[1], ball[2] - origin[2]
    along = x * way[0] + y * way[1] + z * way[2]
    square = x**2 + y**2 + z**2
    return along, math.sqrt(max(0.0, square - along * along))


@part
def _ground_along(eye: Floats, way: Floats, scene: Floats) -> float:
    """Return how far along a ray the floor or the wall is met."""
    wall = (scene[WALL_Z] - eye[2]) / way[2] if way[2] > 0 else 1e9
    floor = -eye[1] / way[1] if way[1] < 0 else 1e9
    return min(wall, floor)


@part
def _rolled(scene: Floats, right: float, up: float) -> tuple[float, float]:
    """Return the direction that an upright camera would see where this one sees another."""
    c, s = math.cos(scene[ROLL]), math.sin(scene[ROLL])
    return c * right + s * up, c * up - s * right


@compiled
def near_ball(scene: Floats, ways: Floats, found: NDArray[np.bool_]) -> None:
    """Mark pixels whose middle sees the ball, or ground from which it hides part of the lamp.

    Parameters
    ----------
    ways
        Some of the ball's places and its radius, which holds their distances; shape (S, 4).
    found
        Shape (rows, columns).
    """
    rows, columns = found.shape
    c, s = math.cos(scene[LOOK]), math.sin(scene[LOOK])
    eye, way, lamp, place = scene[EYE : EYE + 3], np.empty(3), np.empty(3), np.empty(3)
    for i in range(rows):
        for j in range(columns):
            up = (0.5 * (rows - 1) - i) / scene[FOCAL]
            right = (j - 0.5 * (columns - 1)) / scene[FOCAL]
            right, up = _rolled(scene, right, up)
            way[0], way[1], way[2] = right, c * up - s, c + s * up
            _unit(way)
            ground = _ground_along(eye, way, scene)
            for k in range(3):
                place[k] = eye[k] + ground * way[k]
                lamp[k] = scene[LAMP + k] - place[k]
            whole = _unit(lamp)
            for n in range(len(ways)):
                seen, beside = _apart(eye, way, ways[n, :3])
                hidden, aside = _apart(place, lamp, ways[n, :3])
                half = 0.87 * scene[LAMP_SIZE] * max(0.0, hidden) / whole
                found[i, j] |= seen > 0.0 and beside < ways[n, 3]
                found[i, j] |= hidden > 0.0 and aside < ways[n, 3] + half


@compiled
def trace(
    scene: Floats,
    boxes: Floats,
    path: tuple[Floats, Floats],
    chosen: NDArray[np.bool_],
    light: Floats,
) -> None:
    """Add the light of one exposure, three colours a pixel.

    Parameters
    ----------
    scene, boxes
        Of a `Stage`.
    path
        Ball at each instant from the first row's exposure to the last row's, and its radius; the
        first row's fourth number seeds the samples, shape (S, 5). By how many instants each row is
        later, shape (rows,).
    chosen
        Pixels to be drawn, shape (rows, columns).
    light
        Shape (rows, columns, 3).
    """
    ways, delays = path
    rows, columns, _ = light.shape
    state = np.array([np.uint64(ways[0, 4]) * np.uint64(2654435761) + np.uint64(88172645463325252)])
    c, s = math.cos(scene[LOOK]), math.sin(scene[LOOK])
    eye, colour, way, lamp = scene[EYE : EYE + 3], np.empty(3), np.empty(3), np.empty(3)
    lasts = len(ways) - int(delays[rows - 1])
    for i in range(rows):
        for j in range(columns):
            if not chosen[i, j]:
                continue
            for n in range(FINE * FINE):
                share = (ORDER[n] + _random(state)) / (FINE * FINE)
                when = int(delays[i] + share * lasts)
                instant = ways[min(when, len(ways) - 1)]
                ball, radius = instant[:3], instant[3]
                up = 0.5 * (rows - 1) - (i + (n // FINE + _random(state)) / FINE - 0.5)
                right = j + (n % FINE + _random(state)) / FINE - 0.5 - 0.5 * (columns - 1)
                right, up = _rolled(scene, right / scene[FOCAL], up / scene[FOCAL])
                way[0], way[1], way[2] = right, c * up - s, c + s * up
                _unit(way)
                met = _meets(eye, way, ball, radius)
                on_floor = False
                if met < 0.0:
                    wall = (scene[WALL_Z] - eye[2]) / way[2] if way[2] > 0 else 1e9
                    floor = -eye[1] / way[1] if way[1] < 0 else 1e9
                    on_floor = floor < wall
                    place = eye + min(wall, floor) * way
                else:
                    place = eye + met * way
                for k in range(3):
                    lamp[k] = scene[LAMP + k] + scene[LAMP_SIZE] * (_random(state) - 0.5) - place[k]
                _unit(lamp)
                if met >= 0.0:
                    _ball_colour(scene, (place - ball) / radius, way, lamp, colour)
                else:
                    _ground_colour(scene, boxes, place, on_floor, colour)
                    facing = max(0.0, lamp[1] if on_floor else -lamp[2])
                    shine = 0.0 if _meets(place, lamp, ball, radius) > 0.0 else facing
                    colour *= scene[AMBIENT] + (1 - scene[AMBIENT]) * shine
                light[i, j] += colour / (FINE * FINE)
