"""What sizes of a compressed film do to e of a ball of unknown mass is in the error of e."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from analysis.balls.flight.fit import fit_flights
from analysis.balls.flight.known import Ball, Known, View
from analysis.balls.settling import Fit, by_sizes
from analysis.balls.systematics import ByRadius
from tests.unit.analysis.balls.test_looking_down import LASTS, before_a_telephone

RADIUS = 52.0


def fitted(
    shrinks: float, *, density: float | None = None, compressed: bool = True
) -> tuple[Fit, ByRadius]:
    """Fit a ball that a telephone sees the smaller, the faster it is: by a share at 4 m/s."""
    seen, begin = before_a_telephone(4)
    scale = 2100.0 / 0.8
    speeds = np.gradient(seen.places[:, 0], seen.times_s) / scale
    noise = 1e-3 * np.random.default_rng(1).standard_normal(len(speeds))
    sizes = np.stack([noise - shrinks * np.abs(speeds) / 4.0, np.full(len(speeds), 1e-3)], axis=1)
    plain = replace(seen, leans=np.zeros_like(seen.places))
    view = View(1920, 1080, 1 / 30.0, 0.01, "rows", compressed=compressed)
    known = Known(Ball(2 * RADIUS / scale, density=density), view, RADIUS)
    flights = fit_flights(plain, begin, known)
    assert flights is not None
    return (plain, begin, known, flights), ByRadius(seen.frames, np.zeros_like(seen.places), sizes)


@pytest.mark.parametrize("shrinks", [0.02, 0.05, 0.1])
def test_e_without_misleading_sizes_is_within_the_error_that_sizes_add(shrinks: float) -> None:
    fit, of_radius = fitted(shrinks)
    changed = by_sizes([fit], of_radius)
    flights = fit[-1]
    assert changed is not None
    # The last flight is seen in four frames: nothing but sizes tells its drift.
    assert changed[-1] > 0.01 > changed[1]
    for bounce, truth in enumerate((LASTS[1:] / LASTS[:-1]).tolist()):
        e, sigma = flights.coefficient(bounce)
        assert abs(e - truth) < 3.0 * math.hypot(sigma, changed[bounce])


def test_sizes_add_no_error_where_the_mass_is_stated_or_no_codec_was_at_them() -> None:
    fit, of_radius = fitted(0.02)
    assert by_sizes([], of_radius) is None
    assert by_sizes([fit], None) is None
    for other in ({"density": 1000.0}, {"compressed": False}):
        fit, of_radius = fitted(0.02, **other)  # type: ignore[arg-type]
        assert by_sizes([fit], of_radius) is None
