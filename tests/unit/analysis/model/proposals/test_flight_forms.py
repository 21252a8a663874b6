"""A force between the spheres is integrated as finely as it falls off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.effects.effect import FlightEffect
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.predict.prediction import predict
from analysis.model.proposals.forms.flight import FlightForm, flight_forms
from tests.unit.analysis.model.hard_spheres import RADIUS, campaign

Floats = NDArray[np.float64]

POWER, STRENGTH = 4.0, 0.5


def displaced(data: PoseData, fit: Fit, effect: FlightEffect) -> Floats:
    """Return how much nearer the spheres are in the last frame, m, shape (S,)."""
    theory = fit.theory.with_effect(effect, np.array([STRENGTH]))
    change = (
        predict(data, fit.states, theory).position - predict(data, fit.states, fit.theory).position
    )
    return np.asarray(np.linalg.norm(change[:, -1, 1] - change[:, -1, 0], axis=-1))


def by_many_steps(data: PoseData, fit: Fit) -> Floats:
    """Return the same by adding up twenty thousand steps along the straight ways."""
    places = predict(data, fit.states, fit.theory).position[:, -2:]
    apart = places[:, :, 1] - places[:, :, 0]
    step = data.times_s[:, -1] - data.times_s[:, -2]
    velocity = (apart[:, 1] - apart[:, 0]) / step[:, None]
    lasts = data.times_s[:, -1] - fit.states.time_s
    found = []
    for s, end in enumerate(lasts):
        since = (np.arange(20_000) + 0.5) / 20_000 * end
        way = apart[s, 1] - velocity[s] * (end - since)[:, None]
        distance = np.linalg.norm(way, axis=1)
        pull = 2 * STRENGTH * (2 * RADIUS / distance) ** POWER
        moved = ((end - since) * pull) @ (way / distance[:, None]) * end / 20_000
        found.append(np.linalg.norm(moved))
    return np.array(found)


def test_a_steep_force_moves_the_spheres_as_many_small_steps_do() -> None:
    data = campaign(6, 3)
    fit = fit_campaign(data)
    sphere = data.bodies[0]
    effect = FlightForm("central", (POWER,), 2 * sphere.radius, sphere.mass).effect("pull")
    expected = by_many_steps(data, fit)
    np.testing.assert_allclose(displaced(data, fit, effect), expected, rtol=2e-3)
    coarse = displaced(data, fit, replace(effect, nodes=2))
    assert (coarse / expected).min() < 0.9, "two nodes would not do"


def test_every_force_is_off_at_zero_and_acts_otherwise() -> None:
    data = campaign(3, 4)
    fit = fit_campaign(data)
    still = predict(data, fit.states, fit.theory).position
    sphere = data.bodies[0]
    for form in flight_forms(2 * sphere.radius, sphere.mass):
        effect = form.effect("force")
        for size, moves in ((0.0, False), (1.0, True)):
            values = np.full(len(form.symbols), size)
            theory = fit.theory.with_effect(effect, values)
            moved = predict(data, fit.states, theory).position
            assert bool(np.abs(moved - still).max() > 1e-9) == moves, form.kind
