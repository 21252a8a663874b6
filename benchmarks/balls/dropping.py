"""The law of a drawn film: flight with quadratic drag, contacts, e that depends on speed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]

GRAVITY, AIR = 9.80665, 1.2
STEP_S = 2e-5


@dataclass(frozen=True, slots=True, eq=False)
class Drop:
    """A ball that is let go: metres, kg; y up, the floor at 0.

    Attributes
    ----------
    diameter, mass, drag_coefficient
        Of the ball.
    start, speed
        Of its centre at time 0, shape (3,).
    restitution
        e0, slope and power: e = e0 - slope v^power.
    grip
        Share of the speed along the floor that a bounce leaves.
    lean
        Of the floor against the horizontal, rad: things on it run to greater x.
    wall
        Place x of a plumb wall that the ball is thrown at, and its e; None: there is none.
    contact_s
        How long a bounce off the floor lasts: half a sine of a spring that the ball is pressed
        into, which does not depend on speed.
    """

    diameter: float
    mass: float
    drag_coefficient: float
    start: Floats
    speed: Floats
    restitution: tuple[float, float, float]
    grip: float
    lean: float = 0.0
    wall: tuple[float, float] | None = None
    contact_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Bounce:
    """A bounce: when, speeds along the normal before and after, and their ratio."""

    time: float
    v_n: float
    v_n_after: float

    @property
    def e(self) -> float:
        """Return the ratio of the speeds."""
        return self.v_n_after / self.v_n


def fly(drop: Drop, lasts: float) -> tuple[Floats, Floats, list[Bounce]]:
    """Return times, places of the centre and bounces; midpoint steps, contacts between them.

    In plain numbers: arrays of three take six times as long, for tens of thousands of steps.
    """
    area = np.pi * (0.5 * drop.diameter) ** 2
    k = float(0.5 * AIR * drop.drag_coefficient * area / drop.mass)
    radius = 0.5 * drop.diameter
    count = int(lasts / STEP_S)
    places: list[Vector] = []
    x, v = _vector(drop.start), _vector(drop.speed)
    down = (GRAVITY * math.sin(drop.lean), -GRAVITY * math.cos(drop.lean), 0.0)
    bounces: list[Bounce] = []
    for n in range(count):
        if bounces and (since := n * STEP_S - bounces[-1].time) < drop.contact_s:
            deep = bounces[-1].v_n * drop.contact_s / math.pi
            places.append((x[0], x[1] - deep * math.sin(math.pi * since / drop.contact_s), x[2]))
            x = _moved(x, STEP_S, (v[0], 0.0, v[2]))
            continue
        places.append(x)
        middle = _moved(v, 0.5 * STEP_S, _pulled(v, down, k))
        change = _pulled(middle, down, k)
        ahead = _moved(x, STEP_S, middle)
        if ahead[1] < radius and v[1] < 0:
            part = (x[1] - radius) / (x[1] - ahead[1])
            v = _moved(v, part * STEP_S, change)
            e0, slope, power = drop.restitution
            e = e0 - slope * (-v[1]) ** power
            bounces.append(Bounce((n + part) * STEP_S, -v[1], -e * v[1]))
            x = _moved(x, part * STEP_S, middle)
            v = (drop.grip * v[0], -e * v[1], drop.grip * v[2])
            rest = (1 - part) * STEP_S
            x = _moved(x, rest, v)
            v = _moved(v, rest, _pulled(v, down, k))
        elif drop.wall is not None and ahead[0] > drop.wall[0] - radius and v[0] > 0:
            # The ball turns within a step, which moves it by a few hundredths of a millimetre.
            bounces.append(Bounce(n * STEP_S, v[0], drop.wall[1] * v[0]))
            x, v = _moved(x, STEP_S, middle), _moved(v, STEP_S, change)
            v = (-drop.wall[1] * v[0], drop.grip * v[1], drop.grip * v[2])
        else:
            x, v = ahead, _moved(v, STEP_S, change)
    return STEP_S * np.arange(count, dtype=np.float64), np.array(places).reshape(-1, 3), bounces


def _vector(numbers: Floats) -> Vector:
    x, y, z = numbers.tolist()
    return x, y, z


def _moved(at: Vector, time: float, rate: Vector) -> Vector:
    return at[0] + time * rate[0], at[1] + time * rate[1], at[2] + time * rate[2]


def _pulled(v: Vector, down: Vector, k: float) -> Vector:
    """Return the acceleration by gravity and quadratic drag."""
    drag = k * math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    return down[0] - drag * v[0], down[1] - drag * v[1], down[2] - drag * v[2]
