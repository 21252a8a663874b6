import numpy as np
import pytest

from simulators.world.description import Sphere, Tube, WorldDescription
from simulators.world.encounter import simulate
from simulators.world.launch import Departure, Launch, Loaded, depart, muzzle_speed
from simulators.world.optics import front_view

SPHERE, TUBE = Sphere(), Tube()
QUIET = WorldDescription(
    tube=Tube(
        speed_scatter=0.0,
        direction_scatter_rad=0.0,
        position_scatter_m=0.0,
        spin_scatter_rad_per_s=0.0,
        valve_jitter_s=0.0,
    )
)


def departures(pressure: float, number: int = 300) -> list[Departure]:
    rng = np.random.default_rng(1)
    loaded = Loaded(TUBE, SPHERE, -0.003, -1.0)
    return [depart(loaded, pressure, 0.0, rng) for _ in range(number)]


def test_more_pressure_always_means_more_speed() -> None:
    speeds = [muzzle_speed(pressure, SPHERE, TUBE) for pressure in np.linspace(6.0, 120.0, 40)]
    assert np.all(np.diff(speeds) > 0.0)


@pytest.mark.parametrize(("pressure", "speed"), [(25.0, 1.3), (95.0, 2.8)])
def test_the_speeds_are_those_of_the_apparatus(pressure: float, speed: float) -> None:
    assert muzzle_speed(pressure, SPHERE, TUBE) == pytest.approx(speed, rel=0.01)


def test_a_heavier_sphere_leaves_with_the_same_energy() -> None:
    heavy = Sphere(density_kg_per_m3=7800.0)
    energies = [0.5 * it.mass_kg * muzzle_speed(60.0, it, TUBE) ** 2 for it in (SPHERE, heavy)]
    assert energies[0] == pytest.approx(energies[1])


def test_too_little_pressure_leaves_the_sphere_in_its_tube() -> None:
    assert depart(Loaded(TUBE, SPHERE, 0.0, 1.0), 5.0, 0.0, np.random.default_rng(0)) is None


def test_scatter_has_the_stated_size() -> None:
    leaving = departures(60.0)
    velocities = np.array([it.exit.velocity for it in leaving])
    speeds = np.linalg.norm(velocities, axis=1)
    # The standard deviation of 300 draws is itself known to 4 %.
    assert speeds.std() / speeds.mean() == pytest.approx(TUBE.speed_scatter, rel=0.17)
    tilt = velocities[:, 0] / speeds
    assert tilt.std() == pytest.approx(TUBE.direction_scatter_rad, rel=0.17)
    spins = np.array([it.exit.spin for it in leaving])
    assert spins.std() == pytest.approx(TUBE.spin_scatter_rad_per_s, rel=0.1)


def test_the_right_tube_fires_to_the_left() -> None:
    assert all(it.exit.velocity[1] < 0.0 < it.exit.centre[1] for it in departures(60.0, 20))


def test_the_push_takes_the_time_of_constant_acceleration_and_the_rest_coasts() -> None:
    leaving = depart(Loaded(QUIET.tube, SPHERE, 0.0, 1.0), 60.0, 0.0, np.random.default_rng(0))
    speed = muzzle_speed(60.0, SPHERE, TUBE)
    way = SPHERE.radius_m - TUBE.stroke_m
    expected = TUBE.valve_delay_s + 2.0 * TUBE.stroke_m / speed + way / speed
    assert leaving.exit_s == pytest.approx(expected)


def test_the_sphere_starts_a_radius_inside_the_mouth_and_never_jumps() -> None:
    leaving = departures(60.0, 1)[0]
    times = np.linspace(leaving.starts_s, leaving.exit_s, 2000)
    way = np.array(
        [np.linalg.norm(leaving.at(time).centre - leaving.exit.centre) for time in times]
    )
    assert way[0] == pytest.approx(SPHERE.radius_m)
    assert way[-1] == pytest.approx(0.0, abs=1e-12)
    fastest = np.linalg.norm(leaving.exit.velocity) * (times[1] - times[0])
    assert np.all(np.diff(way) <= 0.0)
    assert np.abs(np.diff(way)).max() <= fastest * (1.0 + 1e-6)


@pytest.mark.parametrize("pressure", [20.0, 50.0, 100.0])
@pytest.mark.parametrize("offset_mm", [0.0, 8.0, 16.0, 22.0])
def test_equal_pressures_meet_within_the_field(pressure: float, offset_mm: float) -> None:
    description = WorldDescription()
    optics = description.optics
    for shot in range(3):
        launch = Launch(pressure, pressure, offset_mm * 1e-3)
        contact = simulate(description, launch, np.random.default_rng(shot)).contact
        assert contact is not None
        for motion in contact.motions[0]:
            row, column = front_view(optics).centre_px(motion.centre, optics.scale_px_per_m)
            # Discs are 40 pixels wide; up to three rows may reach into the mirror's view.
            assert optics.front_rows[0] + 17 <= row <= optics.front_rows[1] - 20
            assert 20 <= column <= optics.columns - 20


def test_firing_b_later_moves_the_meeting_toward_its_tube() -> None:
    meetings = []
    for delay in (-0.004, 0.0, 0.004):
        contact = simulate(
            QUIET, Launch(40.0, 40.0, 0.004, 7.0, 7.0 + delay), np.random.default_rng(0)
        ).contact
        meetings.append(sum(motion.centre[1] for motion in contact.motions[0]) / 2.0)
    speed = muzzle_speed(40.0, SPHERE, TUBE)
    # Whoever has a head start is further by speed times delay, half of which shifts the middle.
    np.testing.assert_allclose(np.diff(meetings), speed * 0.004 / 2.0, rtol=0.01)


def test_tube_b_sits_lower_by_the_offset() -> None:
    encounter = simulate(QUIET, Launch(40.0, 40.0, 0.012), np.random.default_rng(0))
    a, b = encounter.poses(0.03)
    assert b.centre[0] - a.centre[0] == pytest.approx(0.012, abs=1e-9)


def test_a_lone_sphere_flies_on_when_the_other_stays_in_its_tube() -> None:
    encounter = simulate(QUIET, Launch(40.0, 5.0, 0.0), np.random.default_rng(0))
    a, b = encounter.poses(0.05)
    assert encounter.contact is None
    assert a is not None
    assert b is None
