import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from analysis.collision.impact import (
    ContactState,
    ImpactVelocities,
    impact_velocities,
    surface_velocity,
)

ACROSS = np.array([0.0, 1.0, 0.0])
STILL = np.zeros(3)
UNIT = (1.0, 1.0)
INERTIA = 0.4


def state(
    velocity_a: tuple[float, float, float],
    velocity_b: tuple[float, float, float],
    spin_a: tuple[float, float, float] = (0.0, 0.0, 0.0),
    spin_b: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> ContactState:
    return ContactState(*(np.array(v) for v in (velocity_a, velocity_b, spin_a, spin_b)))


def test_a_head_on_elastic_impact_exchanges_the_velocities() -> None:
    before = state((0.0, 2.0, 0.0), (0.0, -1.0, 0.0))
    after = state((0.0, -1.0, 0.0), (0.0, 2.0, 0.0))
    found = impact_velocities(before, after, ACROSS, UNIT)
    assert (found.v_n, found.v_n_after, found.v_s, found.e) == (-3.0, 3.0, 0.0, 1.0)
    assert math.isnan(found.beta)


def test_a_sliding_impact_after_walton_worked_by_hand() -> None:
    # Unit masses and radii, e = 0.5, mu = 0.1: normal impulse 1.5, tangential 0.15 along X. It
    # gives each sphere 0.15 m/s and 0.15 / 0.4 rad/s. v_s' = 2 - 0.1 (1.5) 2 (3.5) = 0.95.
    before = state((1.0, 1.0, 0.0), (-1.0, -1.0, 0.0))
    after = state((0.85, -0.5, 0.0), (-0.85, 0.5, 0.0), (0.0, 0.0, 0.375), (0.0, 0.0, 0.375))
    found = impact_velocities(before, after, ACROSS, UNIT)
    assert (found.v_n, found.v_s, found.v_n_after) == pytest.approx((-2.0, 2.0, 1.0))
    assert found.v_s_after == pytest.approx(0.95)
    assert found.e == pytest.approx(0.5)
    assert found.beta == pytest.approx(-0.475)
    assert found.v_s_across == pytest.approx(0.0)


def test_a_rolling_impact_after_walton_turns_the_surface_velocity_round() -> None:
    # As above with beta0 = 0.5: tangential impulse 0.5 (1.5) 2 / 3.5 = 3/7; v_s' = -1.
    push, turn = 3 / 7, 3 / 7 / INERTIA
    before = state((1.0, 1.0, 0.0), (-1.0, -1.0, 0.0))
    after = state(
        (1.0 - push, -0.5, 0.0), (push - 1.0, 0.5, 0.0), (0.0, 0.0, turn), (0.0, 0.0, turn)
    )
    found = impact_velocities(before, after, ACROSS, UNIT)
    assert found.v_s_after == pytest.approx(-1.0)
    assert found.beta == pytest.approx(0.5)


def test_spheres_that_roll_on_each_other_have_no_surface_velocity() -> None:
    # Like gears: opposite spins of equal surface speed.
    rolling = state((0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 7.0), (0.0, 0.0, -7.0))
    np.testing.assert_allclose(surface_velocity(rolling, ACROSS, UNIT), 0.0, atol=1e-15)


def test_each_spin_counts_by_its_own_radius() -> None:
    turning = state((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 10.0), (0.0, 0.0, 100.0))
    # The surface of a at the contact moves by w x (+R_a n), that of b by w x (-R_b n).
    at_a = np.cross([0.0, 0.0, 10.0], 0.02 * ACROSS)
    at_b = np.cross([0.0, 0.0, 100.0], -0.01 * ACROSS)
    found = surface_velocity(turning, ACROSS, (0.02, 0.01))
    np.testing.assert_allclose(found, at_b - at_a)


def test_what_stands_across_the_incident_direction_is_told_apart() -> None:
    before = state((0.0, 1.0, 0.0), (3.0, -1.0, 0.0))
    after = state((0.0, -0.5, 0.0), (-1.0, 0.5, 2.0))
    found = impact_velocities(before, after, ACROSS, UNIT)
    assert found.v_s_after == pytest.approx(-1.0)
    assert abs(found.v_s_across) == pytest.approx(2.0)


def test_table_3_3_of_the_thesis_gives_its_restitution() -> None:
    measured = ImpactVelocities(*np.array([-68.330, 170.586, 48.052, 149.526, 0.0]))
    assert measured.e == pytest.approx(0.703, abs=5e-4)
    # Sliding line: v_s' = v_s - mu (1 + e) |v_n| (1 + 1/K), K = 0.4, with the thesis's mu of 0.052.
    slowed = 0.052 * (1 + measured.e) * 68.330 * 3.5
    assert measured.v_s - measured.v_s_after == pytest.approx(slowed, rel=0.01)


component = st.floats(-5.0, 5.0)
triples = st.tuples(component, component, component).map(np.array)
states = st.builds(ContactState, triples, triples, triples, triples)
turns = st.integers(0, 10**6).map(lambda seed: Rotation.random(rng=np.random.default_rng(seed)))


def scalars(found: ImpactVelocities) -> tuple[float, ...]:
    v = found.v_n, found.v_s, found.v_n_after, found.v_s_after
    return tuple(map(float, v))


def rotated(contact: ContactState, turn: Rotation) -> ContactState:
    parts = (contact.velocity_a, contact.velocity_b, contact.spin_a, contact.spin_b)
    return ContactState(*(turn.apply(part) for part in parts))


def renamed(contact: ContactState) -> ContactState:
    return ContactState(contact.velocity_b, contact.velocity_a, contact.spin_b, contact.spin_a)


@given(before=states, after=states, turn=turns, other=turns)
def test_the_axes_do_not_matter(
    before: ContactState, after: ContactState, turn: Rotation, other: Rotation
) -> None:
    normal = other.apply(ACROSS)
    here = impact_velocities(before, after, normal, (0.0127, 0.01))
    there = impact_velocities(
        rotated(before, turn), rotated(after, turn), turn.apply(normal), (0.0127, 0.01)
    )
    if here.v_s > 1e-3:
        assert scalars(there) == pytest.approx(scalars(here), abs=1e-9)


@given(before=states, after=states, turn=turns)
def test_the_names_of_the_spheres_do_not_matter(
    before: ContactState, after: ContactState, turn: Rotation
) -> None:
    normal = turn.apply(ACROSS)
    one = impact_velocities(before, after, normal, (0.0127, 0.01))
    other = impact_velocities(renamed(before), renamed(after), -normal, (0.01, 0.0127))
    assert scalars(other) == pytest.approx(scalars(one), abs=1e-9)


def test_many_impacts_at_once_are_what_each_is_alone() -> None:
    rng = np.random.default_rng(2)
    before, after = (ContactState(*rng.normal(size=(4, 5, 3))) for _ in range(2))
    normals = Rotation.random(5, rng=rng).apply(ACROSS)
    together = impact_velocities(before, after, normals, (0.0127, 0.01))

    def one(contact: ContactState, n: int) -> ContactState:
        parts = (contact.velocity_a, contact.velocity_b, contact.spin_a, contact.spin_b)
        return ContactState(*(part[n] for part in parts))

    for n in range(5):
        alone = impact_velocities(one(before, n), one(after, n), normals[n], (0.0127, 0.01))
        assert together.beta[n] == pytest.approx(float(alone.beta))
        assert together.v_s_across[n] == pytest.approx(float(alone.v_s_across))
