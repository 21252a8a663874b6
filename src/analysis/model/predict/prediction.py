"""Poses as the theory predicts them from the state of each shot.

    state --contact--> state after --flight--> positions and orientations at the frames' true
    times --camera--> where the images show them

Both sides of the contact share its point, instant and orientations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import (
    BodyEffect,
    CameraEffect,
    ClockEffect,
    Exposure,
    FlightEffect,
    Flying,
    Turning,
    Values,
)
from analysis.model.data.poses import PoseData
from analysis.model.loops import plain
from analysis.model.loops.flight import free_flight
from analysis.model.predict.contact import contact_outcome
from analysis.model.predict.passages import Passage, felt, gauss_legendre
from analysis.model.predict.sides import Flights, flights
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory
from analysis.motion.rotation import rotation_matrix

LONG_NODES = 6
"""Instants at which forces on a ball that bounces on a plate are evaluated: it flies for long."""
_CLOCK_PASSES = 2
"""A time that hangs on the place hangs on it at that time: the second pass knows where."""


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Predicted positions (S, F, 2, 3), m, and orientations (S, F, 2, 3, 3), body to rig axes."""

    position: Floats
    rotation: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Timing:
    """True times since first touch, s, by sphere.

    Attributes
    ----------
    position
        Of each coordinate, as the two views may show a sphere at two times, shape (S, F, 2, 3).
    rotation
        Of the orientation, shape (S, F, 2).
    """

    position: Floats
    rotation: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Flown:
    """Free flight at the frames' true times, before small forces and the camera.

    Attributes
    ----------
    stated, timing
        Times since first touch as stated, and as they truly are.
    position, velocity
        At mid exposure, without gravity's part in the velocity; shape (S, F, 2, 3).
    touch
        Orientations at first touch, shape (S, 2, 3, 3).
    duration
        Of the contact, s, shape (S,).
    spin, rotation, jacobian
        Spin, shape (S, F, 2, 3), orientation, and the left Jacobian of spin times time, shape
        (S, F, 2, 3, 3).
    turned
        The rotation since tau = 0, shape (S, F, 2, 3, 3).
    """

    stated: Timing
    timing: Timing
    touch: Floats
    position: Floats
    velocity: Floats
    duration: Floats
    spin: Floats
    rotation: Floats
    jacobian: Floats
    turned: Floats

    @property
    def since(self) -> tuple[Floats, Floats]:
        """Time since this side began, of coordinates (S, F, 2, 3) and orientations (S, F, 2)."""
        tau, tau_turn = self.timing.position, self.timing.rotation
        late = self.duration[:, None, None]
        return (
            tau - np.where(tau > 0, late[..., None], 0.0),
            tau_turn - np.where(tau_turn > 0, late, 0.0),
        )


def predict(data: PoseData, states: ShotStates, theory: Theory) -> Poses:
    """Predict the pose of both spheres in every frame."""
    flown = fly(data, states, flights(data, states, contact_outcome(data, states, theory)), theory)
    return shown(OnWay(data, flown, theory.flight), theory)


def fly(data: PoseData, states: ShotStates, sides: Flights, theory: Theory) -> Flown:
    """Follow both flights of both spheres to the frames' true times."""
    stated = data.times_s - states.time_s[:, None]
    start = Timing(
        np.broadcast_to(stated[..., None, None], (*stated.shape, 2, 3)).copy(),
        np.broadcast_to(stated[..., None], (*stated.shape, 2)).copy(),
    )
    flown = _free_flight(data, sides, start, start)
    for _ in range(_CLOCK_PASSES if theory.clock else 0):
        timing = exposed(data, start, flown.position, theory.clock)
        flown = _free_flight(data, sides, start, timing)
    return flown


def rate(data: PoseData, flown: Flown) -> Floats:
    """Return the velocities in all frames, gravity in, m/s, shape (S, F, 2, 3)."""
    velocity = flown.velocity.copy()
    velocity[..., 0] += data.gravity * flown.timing.position[..., 0]
    return velocity


def shown(way: OnWay, theory: Theory) -> Poses:
    """Add what small forces do on the way, and what turning and camera make of place and turn."""
    data, flown, rotation = way.data, way.flown, way.flown.rotation
    position = flown.position
    if theory.flight:
        push, twist = way.pushed(theory.flight)
        position = position + push
        rotation = rotation if twist is None else rotation_matrix(twist) @ rotation
    position = displaced(data, flown, position, theory.body)
    turned = theory.orientation
    if turned is not None:
        rotation = rotation_matrix(turned) @ rotation
    return Poses(appear(data, position, theory.camera), rotation)


def displaced(
    data: PoseData,
    flown: Flown,
    position: Floats,
    effects: Sequence[tuple[BodyEffect, Values]],
) -> Floats:
    """Return the centres of outlines from centres of mass, shape (S, F, 2, 3).

    Where each shot has body axes of its own, nothing fixed in a body can be foretold.
    """
    if not data.slow.one_body_frame:
        return position
    for effect, values in effects:
        position = effect.displace(Turning(position, flown.rotation, flown.touch), values)
    return position


def appear(
    data: PoseData, position: Floats, effects: Sequence[tuple[CameraEffect, Values]]
) -> Floats:
    """Return where the images show centres, shape (S, F, 2, 3)."""
    for effect, values in effects:
        position = effect.appear(position, data.camera, values)
    return position


Forces = Sequence[tuple[FlightEffect, Values]]
Change = tuple[Floats, Floats | None]
"""Displacement, m, and rotation vector, shape (S, F, 2, 3); None: a force that turns nothing."""


class OnWay:
    """What small forces find and do on the way.

    Attributes
    ----------
    data, flown
        Of the flights without them.
    """

    def __init__(self, data: PoseData, flown: Flown, flight: Forces) -> None:
        self.data, self.flown = data, flown
        self._passages: dict[int, list[Passage]] = {}
        self._units: dict[str, Change] = {}
        # Every step of another effect starts from what these do.
        self._own = {_key(*force): self._change(*force) for force in flight}

    def pushed(self, flight: Forces) -> Change:
        """Return what small forces add together."""
        push, twist = np.zeros_like(self.flown.position), None
        for force in flight:
            own = self._own.get(_key(*force))
            pushed, turned = self._change(*force) if own is None else own
            push = push + pushed
            if turned is not None:
                twist = turned if twist is None else twist + turned
        return push, twist

    def _change(self, effect: FlightEffect, values: Values) -> Change:
        """Return what an effect adds; one that bends the path is proportional to nothing."""
        if not effect.proportional or self.data.on_plate:
            return self._integrated(effect, values)
        if effect.name not in self._units:
            self._units[effect.name] = self._integrated(effect, np.ones(1))
        push, twist = self._units[effect.name]
        return values[0] * push, None if twist is None else values[0] * twist

    def _integrated(self, effect: FlightEffect, values: Values) -> Change:
        """Integrate what an effect adds.

        Double integrals of the acceleration, int_0^t (t - s) a(s) ds: along the unperturbed path
        and, where flights last long, along the one that the effect itself bends.
        """
        push, twist = np.zeros_like(self.flown.position), np.zeros_like(self.flown.position)
        turns = False
        for i in (0, 1):
            # In arrays of their own: a sphere's part of the whole is slow to add to.
            pushed, twisted = np.zeros((2, *push[:, :, i].shape))
            on_way = [one for one in self._found(effect.nodes) if one.sphere == i]
            found = felt(on_way, effect, values, bent=self.data.on_plate)
            for passage, (linear, angular) in zip(on_way, found, strict=True):
                if np.any(linear):
                    pushed += passage.push * linear
                if np.any(angular):
                    twisted += passage.twist * angular
                    turns = True
            push[:, :, i], twist[:, :, i] = pushed, twisted
        return push, twist if turns else None

    def _found(self, nodes: int) -> list[Passage]:
        """Return the passages of both spheres at the nodes of an integral."""
        if self.data.on_plate:
            nodes = max(nodes, LONG_NODES)
        if nodes not in self._passages:
            self._passages[nodes] = _passages(self.data, self.flown, nodes)
        return self._passages[nodes]


def _key(effect: FlightEffect, values: Values) -> tuple[str, bytes]:
    return effect.name, np.asarray(values).tobytes()


def _passages(data: PoseData, flown: Flown, nodes: int) -> list[Passage]:
    """Return the passages at the Gauss-Legendre nodes of int_0^t (t - s) a(s) ds."""
    since, turning = flown.since
    found = []
    for i, body in enumerate(data.bodies):
        if body.is_plate:
            continue
        own = since[:, :, i]
        for node, share in zip(*gauss_legendre(nodes), strict=True):
            flying = _flying(data, flown, own, i, node)
            twist = share * (1.0 - node) * turning[:, :, i, None] ** 2
            push = share * own * ((1.0 - node) * own)
            found.append(Passage(i, flying, own, push, twist))
    return found


def _flying(data: PoseData, flown: Flown, own: Floats, i: int, node: float) -> Flying:
    """Return the motion of sphere i at a share of the time since its flight began, unperturbed.

    Parameters
    ----------
    own
        That time, s, shape (S, F, 3).
    """
    gravity = np.array([data.gravity, 0.0, 0.0])
    rate_i = np.ascontiguousarray(flown.velocity[:, :, i])
    back = (1.0 - node) * own
    partner = flown.position[:, :, 1 - i] - flown.velocity[:, :, 1 - i] * back
    return Flying(
        position=flown.position[:, :, i] - rate_i * back,
        velocity=rate_i + gravity * node * own,
        spin=np.ascontiguousarray(flown.spin[:, :, i]),
        body=data.bodies[i],
        gravity=data.gravity,
        air_density=data.air_density,
        partner=None if data.on_plate else partner,
    )


def _free_flight(data: PoseData, sides: Flights, stated: Timing, timing: Timing) -> Flown:
    tau, tau_turn = timing.position, timing.rotation
    position, velocity, spin, rotation, jacobian, turned = free_flight(
        (plain(tau), plain(tau_turn)),
        (sides.place, sides.velocity, sides.spin),
        sides.rotation,
        data.gravity,
    )
    return Flown(
        stated=stated,
        timing=timing,
        touch=sides.touch,
        position=position,
        velocity=velocity,
        duration=sides.duration,
        spin=spin,
        rotation=rotation,
        jacobian=jacobian,
        turned=turned,
    )


def exposed(
    data: PoseData,
    start: Timing,
    position: Floats,
    effects: Sequence[tuple[ClockEffect, Values]],
) -> Timing:
    """Return true times from stated ones, of spheres that are seen at these positions."""
    exposure = Exposure(data.times_s, position)
    tau, tau_turn = start.position, start.rotation
    for effect, values in effects:
        seen, turned = effect.expose(exposure, data.camera, values)
        tau = tau + (seen - data.times_s[..., None, None])
        tau_turn = tau_turn + (turned - data.times_s[..., None])
    return Timing(tau, tau_turn)
