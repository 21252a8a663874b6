"""Derivatives of both flights beside differences of the flights themselves."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from analysis.model.fitting.fit import START
from analysis.model.loops.sides import tangents
from analysis.model.predict.contact import differentiated_contact
from analysis.model.predict.sides import Flights, flights, flights_by_outcome, flights_by_state
from analysis.model.predict.start import first_states
from analysis.model.predict.theory import Theory
from benchmarks.discovery.campaigns import campaign

Floats = NDArray[np.float64]


def change(before: Flights, after: Flights) -> Floats:
    """Return the change of the 48 numbers from one pair of flights to another, shape (S, 48)."""
    turns = after.rotation @ np.swapaxes(before.rotation, -1, -2)
    turned = Rotation.from_matrix(turns.reshape(-1, 3, 3)).as_rotvec().reshape(before.place.shape)
    kinds = (
        (after.place - before.place, after.velocity - before.velocity),
        (turned, after.spin - before.spin),
    )
    both = np.stack([np.stack(pair, axis=3) for pair in kinds], axis=2)
    return both.reshape(len(before.place), 48)


DATA = campaign({}, 3, 5)
STATES = first_states(DATA)


def drawn_outcome() -> Floats:
    """Return outcomes of contacts that last, shift and turn, shape (S, 25)."""
    rng = np.random.default_rng(4)
    size = np.repeat([1.0, 100.0, 1e-4, 1e-4, 0.02], [6, 6, 1, 6, 6])
    return np.abs(rng.normal(0, size, (5, 25)))


@pytest.mark.parametrize("number", range(25))
def test_flights_follow_each_number_of_an_outcome(number: int) -> None:
    outcome, steps = drawn_outcome(), np.repeat([1e-4, 1e-2, 1e-7, 1e-6, 1e-4], [6, 6, 1, 6, 6])
    one = np.zeros((5, 25, 1))
    one[:, number] = 1.0
    sides = []
    for way in (1.0, -1.0):
        moved = outcome.copy()
        moved[:, number] += way * steps[number]
        sides.append(change(flights(DATA, STATES, outcome), flights(DATA, STATES, moved)))
    expected = (sides[0] - sides[1]) / (2 * steps[number])
    found = flights_by_outcome(outcome, one)[..., 0]
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(expected).max())


@pytest.mark.parametrize("number", range(1, 24))
def test_flights_follow_each_number_of_a_state(number: int) -> None:
    theory = Theory(START)
    steps = np.repeat([1.0, 1e-6, 1e-6, 1e-5, 1e-3, 1e-5], [1, 3, 2, 6, 6, 6])
    contact = differentiated_contact(DATA, STATES, theory)
    here = flights(DATA, STATES, contact.outcome)
    found = flights_by_state(DATA, STATES, here, contact.outcome, contact.by_state)[..., number]
    step = np.zeros((5, 24))
    step[:, number] = steps[number]
    sides = []
    for way in (step, -step):
        moved = STATES.moved(way)
        there = differentiated_contact(DATA, moved, theory).outcome
        sides.append(change(here, flights(DATA, moved, there)))
    expected = (sides[0] - sides[1]) / (2 * steps[number])
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())


def test_a_later_contact_has_its_flights_a_step_earlier() -> None:
    contact = differentiated_contact(DATA, STATES, Theory(START))
    here = flights(DATA, STATES, contact.outcome)
    found = flights_by_state(DATA, STATES, here, contact.outcome, contact.by_state)[..., 0]
    parts = found.reshape(5, 2, 2, 2, 2, 3)
    np.testing.assert_array_equal(parts[:, :, 0, :, 0], -here.velocity)
    np.testing.assert_array_equal(parts[:, :, 1, :, 0], -here.spin)
    np.testing.assert_array_equal(parts[:, :, 0, :, 1, 0], -DATA.gravity)


def test_tangents_lie_across_each_normal_and_each_other() -> None:
    normal = np.random.default_rng(5).normal(size=(40, 3))
    normal[0] = 0.0, -1.0, 0.0
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    frames = np.stack([*tangents(normal), normal], axis=1)
    np.testing.assert_allclose(
        frames @ np.swapaxes(frames, 1, 2), np.tile(np.eye(3), (40, 1, 1)), atol=1e-15
    )
    # First, second, normal turn to the left.
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, rtol=1e-14)
