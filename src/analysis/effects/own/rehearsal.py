"""A few shots on which an effect is tried, in SI units or in any other consistent ones.

The response of an effect is a row of numbers for each shot, each divided by what is usual of its
kind, so that one threshold does for all. Written in other units of length, time and mass, the same
shots must give the same rows: that is how the unit of a parameter shows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import Body, Encounter, Outcome, States, walton
from analysis.effects.effect import (
    CameraEffect,
    ClockEffect,
    ContactEffect,
    Effect,
    Exposure,
    FlightEffect,
    Flying,
    Values,
)
from analysis.setup import CameraSetup

SHOTS, FRAMES, SEED = 16, 6, 0
RADIUS_M, DENSITY_KG_PER_M3, GRAVITY_M_PER_S2, AIR_KG_PER_M3 = 0.0127, 1150.0, 9.80665, 1.2
ALL = slice(None)
LAW = (0.74, 0.08, 0.5)
USUAL_SPEED_M_PER_S, USUAL_SPIN_RAD_PER_S, USUAL_DURATION_S = 1.0, 80.0, 1e-3


@dataclass(frozen=True, slots=True)
class Units:
    """How many units of length, time and mass make a metre, a second and a kilogram."""

    length: float = 1.0
    time: float = 1.0
    mass: float = 1.0

    @property
    def speed(self) -> float:
        """How many units of speed make a metre a second."""
        return self.length / self.time

    @property
    def acceleration(self) -> float:
        """How many units of acceleration make a metre a second squared."""
        return self.speed / self.time


SI = Units()


@dataclass(slots=True)
class AnyColumn(Mapping[str, Floats]):
    """Columns of a shot list that has a column of any name, 20 to 24 in its unit.

    Attributes
    ----------
    shots
        Those of the shots that take part.
    middle, width
        Of each column, in its unit.
    names_read
        Names other than `order` that the function read.
    """

    shots: slice = field(default_factory=lambda: ALL)
    names_read: set[str] = field(default_factory=set)
    middle: float = 22.0
    width: float = 4.0

    def __getitem__(self, name: str) -> Floats:
        order = np.linspace(-0.5, 0.5, SHOTS)
        if name == "order":
            return order[self.shots]
        self.names_read.add(name)
        return (self.middle + self.width * np.roll(order, 5))[self.shots]

    def __iter__(self) -> Iterator[str]:
        return iter(("order", *sorted(self.names_read)))

    def __len__(self) -> int:
        return 1 + len(self.names_read)


def response(effect: Effect, values: Values, units: Units, columns: AnyColumn) -> Floats:
    """Return the change by an effect in the shots that take part, in usual sizes, shape (S, N).

    Raises
    ------
    EffectFault
        An effect under watch fails.
    """
    if isinstance(effect, ContactEffect):
        return _rows(effect.wrap(walton, values)(_encounter(units, columns)), units)
    if isinstance(effect, FlightEffect):
        linear, angular = effect.accelerate(_flying(units, columns.shots), values)
        usual = GRAVITY_M_PER_S2 * units.acceleration
        return _joined(linear / usual, angular * units.time**2)
    place = _places(columns.shots) * units.length
    if isinstance(effect, CameraEffect):
        seen = effect.appear(place, _camera(units), values)
        return _joined(seen / (RADIUS_M * units.length))
    if isinstance(effect, ClockEffect):
        exposure = Exposure(_times(columns.shots) * units.time, place)
        position, rotation = effect.expose(exposure, _camera(units), values)
        usual = USUAL_DURATION_S * units.time
        return _joined(position / usual, rotation / usual)
    raise TypeError(f"{effect.name} acts in no stage that is tried")


def unchanged(effect: Effect) -> Floats:
    """Return the response of nothing in the stage of an effect, shape (S, N)."""
    if isinstance(effect, ContactEffect):
        return _rows(walton(_encounter(SI, AnyColumn())), SI)
    places = _places(ALL)
    if isinstance(effect, CameraEffect):
        return _joined(places / RADIUS_M)
    if isinstance(effect, ClockEffect):
        stated = np.broadcast_to(_times(ALL)[..., None] / USUAL_DURATION_S, places.shape[:3])
        return _joined(np.repeat(stated, 3, axis=2), stated)
    return np.zeros((SHOTS, 6 * FRAMES))


def _encounter(units: Units, columns: AnyColumn) -> Encounter:
    """Return collisions in every direction, that stick and that slide, at 0.4 to 4 m/s."""
    rng = np.random.default_rng(SEED)
    normal = _unit(rng.normal(size=(SHOTS, 3)))
    along = _unit(np.cross(normal, rng.normal(size=(SHOTS, 3))))
    approach = np.geomspace(0.4, 4.0, SHOTS)[:, None]
    ratio = rng.permutation(np.geomspace(0.05, 4.0, SHOTS))[:, None]
    half = 0.5 * approach * (ratio * along - normal)
    common = rng.normal(0.0, 0.3, (SHOTS, 3))
    spin = rng.normal(0.0, 60.0, (SHOTS, 3))
    shots = columns.shots
    e, mu, beta0 = (np.full(SHOTS, value)[shots] for value in LAW)
    body = _body(units)
    point = rng.uniform(-0.003, 0.003, (SHOTS, 3))
    turned = np.linalg.qr(rng.normal(size=(SHOTS, 2, 3, 3)))[0]
    turned = turned * np.linalg.det(turned)[..., None, None]
    return Encounter(
        before=States(
            velocity_a=(common - half)[shots] * units.speed,
            velocity_b=(common + half)[shots] * units.speed,
            spin_a=spin[shots] / units.time,
            # Opposite spins leave the surface velocity, and with it the sticking shots, alone.
            spin_b=(0.3 * along - spin)[shots] / units.time,
        ),
        normal=normal[shots],
        bodies=(body, body),
        e=e,
        mu=mu,
        beta0=beta0,
        covariates=columns,
        point=point[shots] * units.length,
        rotation=turned[shots],
    )


def _rows(outcome: Outcome, units: Units) -> Floats:
    after, spin = outcome.after, USUAL_SPIN_RAD_PER_S / units.time
    speed, shift = USUAL_SPEED_M_PER_S * units.speed, RADIUS_M * units.length
    return _joined(
        after.velocity_a / speed,
        after.velocity_b / speed,
        after.spin_a / spin,
        after.spin_b / spin,
        outcome.duration / (USUAL_DURATION_S * units.time),
        outcome.shift_a / shift,
        outcome.shift_b / shift,
        outcome.turn_a,
        outcome.turn_b,
    )


def _joined(*parts: Floats) -> Floats:
    """Return arrays of shape (S, ...) side by side, shape (S, N)."""
    return np.concatenate([part.reshape(len(part), -1) for part in parts], axis=1)


def _flying(units: Units, shots: slice) -> Flying:
    rng = np.random.default_rng(SEED)
    shape = (SHOTS, FRAMES, 3)
    position, velocity = rng.uniform(-0.05, 0.05, shape), rng.normal(0.0, 2.0, shape)
    spin, apart = rng.normal(0.0, 60.0, shape), _unit(rng.normal(size=shape))
    gap = 2 * RADIUS_M * rng.uniform(1.0, 4.0, (*shape[:2], 1))
    return Flying(
        position=position[shots] * units.length,
        velocity=velocity[shots] * units.speed,
        spin=spin[shots] / units.time,
        partner=(position + gap * apart)[shots] * units.length,
        body=_body(units),
        gravity=GRAVITY_M_PER_S2 * units.acceleration,
        air_density=AIR_KG_PER_M3 * units.mass / units.length**3,
    )


def _body(units: Units) -> Body:
    sphere = Body.sphere(2 * RADIUS_M, DENSITY_KG_PER_M3, 0.4)
    return Body(
        sphere.mass * units.mass,
        sphere.radius * units.length,
        sphere.inertia * units.mass * units.length**2,
    )


def _places(shots: slice) -> Floats:
    return np.random.default_rng(SEED).uniform(-0.03, 0.03, (SHOTS, FRAMES, 2, 3))[shots]


def _times(shots: slice) -> Floats:
    return np.tile(1e-3 * np.arange(1.0, FRAMES + 1), (SHOTS, 1))[shots]


def _camera(units: Units) -> CameraSetup:
    return CameraSetup(
        frame_rate_hz=1000.0 / units.time,
        height_px=192,
        width_px=240,
        front_view_rows=(88, 192),
        top_view_rows=(0, 88),
        scale_px_per_m=1574.8 / units.length,
        front_origin_px=(132.0, 120.0),
        top_origin_px=(46.0, 120.0),
        exposure_s=1e-4 * units.time,
    )


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
