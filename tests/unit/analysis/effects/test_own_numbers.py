"""Numbers that may carry a unit are seen wherever a function gets them from."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest

from analysis.collision.operator import inverse_masses
from analysis.effects.contact import friction_speed, velocity_offset
from analysis.effects.flight import drag, wind
from analysis.effects.own.checking import has_literal_numbers

SPEED = 2.0
HELD = SimpleNamespace(speed=2.0)


def closure(speed: float) -> Callable[[float], float]:
    return lambda value: value * speed


def constant(value: float) -> float:
    return value * SPEED


def through_another(value: float) -> float:
    return constant(value) + 1


def within(value: float) -> Callable[[], float]:
    def inner() -> float:
        return value * SPEED

    return inner


def by_default(value: float, speed: float = 2.0) -> float:
    return value * speed


def decimal(value: float) -> float:
    return value * 9.81


def held(value: float) -> float:
    return value * float(HELD.speed)


def pure(value: float) -> float:
    return 0.5 * value**2 * math.pi * float(np.sqrt(2)) + 3 * inverse_masses.__code__.co_argcount


def itself(value: float) -> float:
    return itself(value - 1) if value > 0 else 0.0


WITH = [
    closure(2.0),
    constant,
    through_another,
    within,
    by_default,
    decimal,
    held,
    len,
    wind.accelerate,
    velocity_offset.wrap,
    friction_speed.wrap,
]


@pytest.mark.parametrize("function", WITH)
def test_a_number_that_may_have_a_unit_is_seen(function: Callable[..., object]) -> None:
    assert has_literal_numbers(function)


@pytest.mark.parametrize("function", [pure, itself, drag.accelerate])
def test_whole_numbers_and_halves_have_none(function: Callable[..., object]) -> None:
    assert not has_literal_numbers(function)
