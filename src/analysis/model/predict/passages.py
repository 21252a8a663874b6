"""What small forces do along a flight: they are felt at the nodes of the integrals over it.

A ball that bounces on a plate flies for long: where the drag of the air takes some per cent of its
speed, drag along the path without drag is off by as much. There the path is bent by the force that
is sought, and the force found again on it (E. Picard's iteration, 1890).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import FlightEffect, Flying, Values

BENDINGS = 2
"""Of a force that takes a share x of the speed, a share of about x cubed over 6 is left."""


@dataclass(frozen=True, slots=True, eq=False)
class Passage:
    """A sphere on its way to all frames at one node of the integrals, as small forces find it.

    Attributes
    ----------
    sphere
        0 or 1.
    flying
        Its motion there, unperturbed.
    since
        Time since its flight began in each frame, s, shape (S, F, 3).
    push
        Displacement in each frame for a unit of acceleration there, s^2, shape (S, F, 3).
    twist
        Rotation for a unit of angular acceleration, s^2, shape (S, F, 1).
    """

    sphere: int
    flying: Flying
    since: Floats
    push: Floats
    twist: Floats


def felt(
    passages: Sequence[Passage], effect: FlightEffect, values: Values, *, bent: bool
) -> list[tuple[Floats, Floats]]:
    """Return the accelerations and angular accelerations of an effect at each node of a flight.

    Parameters
    ----------
    passages
        Of one sphere at the nodes of `gauss_legendre`, in their order.
    bent
        Whether they are those along the path that the effect itself bends; spins stay as they are.
    """
    found = [effect.accelerate(passage.flying, values) for passage in passages]
    for _ in range(BENDINGS if bent else 0):
        linear = [one[0] for one in found]
        if not any(map(np.any, linear)):
            break
        found = [effect.accelerate(flying, values) for flying in _bent(passages, linear)]
    return found


def _bent(passages: Sequence[Passage], linear: Sequence[Floats]) -> list[Flying]:
    """Return the motion at each node with what accelerations at all nodes have done until then."""
    rates, shifts = _until(len(passages))
    flying = []
    for passage, rate, shift in zip(passages, rates, shifts, strict=True):
        gained = sum(share * own for share, own in zip(rate, linear, strict=True))
        moved = sum(share * own for share, own in zip(shift, linear, strict=True))
        flying.append(
            replace(
                passage.flying,
                position=passage.flying.position + passage.since**2 * moved,
                velocity=passage.flying.velocity + passage.since * gained,
            )
        )
    return flying


@cache
def gauss_legendre(nodes: int) -> tuple[Floats, Floats]:
    """Return the places of nodes from 0 to 1 and their weights."""
    places, weights = np.polynomial.legendre.leggauss(nodes)
    return (1.0 + places) / 2.0, weights / 2.0


@cache
def _until(nodes: int) -> tuple[Floats, Floats]:
    """Return integrals and double integrals from 0 to each node by values at all nodes.

    Of the polynomial through the values; both of shape (nodes, nodes).
    """
    places = gauss_legendre(nodes)[0]
    powers = np.arange(nodes)
    polynomial = np.linalg.inv(places[:, None] ** powers)
    once = places[:, None] ** (powers + 1) / (powers + 1)
    twice = places[:, None] ** (powers + 2) / ((powers + 1) * (powers + 2))
    return once @ polynomial, twice @ polynomial
