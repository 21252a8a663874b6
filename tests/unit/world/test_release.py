"""Spheres that roll out of tilted tubes, and spheres that fall on a plate, by arithmetic."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from simulators.world import WorldDescription
from simulators.world.bounces import drop
from simulators.world.contact import collide
from simulators.world.description import ContactLaw, Environment, Magnet, Sphere, TiltedTubes
from simulators.world.encounter import Encounter
from simulators.world.firing import fire
from simulators.world.release import Held, Release, roll

NO_SCATTER = {
    "release_jitter_s": 0.0,
    "speed_scatter": 0.0,
    "direction_scatter_rad": 0.0,
    "position_scatter_m": 0.0,
    "spin_scatter_rad_per_s": 0.0,
}
EXACT = Magnet(
    height_m=-0.05,
    plate_m=0.1,
    release_jitter_s=0.0,
    position_scatter_m=0.0,
    drift_scatter_m_per_s=0.0,
    spin_scatter_rad_per_s=0.0,
)
VACUUM = Environment(gravity_m_per_s2=9.81, air_density_kg_per_m3=0.0)


@pytest.mark.parametrize("toward", [+1.0, -1.0])
def test_a_sphere_leaves_a_tube_with_the_energy_of_its_descent_and_rolling(toward: float) -> None:
    tubes, sphere = TiltedTubes(length_m=0.2, **NO_SCATTER), Sphere()
    leaving = roll(Held(tubes, sphere, 30.0, toward), 0.0, VACUUM, np.random.default_rng(1))
    motion = leaving.exit
    descent = 9.81 * 0.2 * math.sin(math.radians(30.0))
    speed, spin = float(np.linalg.norm(motion.velocity)), float(np.linalg.norm(motion.spin))
    energy = 0.5 * speed**2 + 0.5 * 0.4 * sphere.radius_m**2 * spin**2
    assert energy == pytest.approx(descent, rel=1e-9)
    assert spin == pytest.approx(speed / sphere.radius_m, rel=1e-9)
    assert motion.velocity[0] > 0.0
    assert motion.velocity[1] * toward > 0.0
    # The lowest point of a sphere that rolls toward +Y moves toward -Y about the centre.
    lowest = np.cross(motion.spin, np.array([sphere.radius_m, 0.0, 0.0]))
    assert lowest[1] * toward < 0.0


def test_solenoids_that_let_go_together_bring_the_spheres_together() -> None:
    description = WorldDescription(holder=TiltedTubes(**NO_SCATTER))
    met = fire(description, Release(5.0, 5.0), np.random.default_rng(1))
    assert met.contact is not None
    a, b = met.contact.motions[0]
    # Mirror images of each other about the middle: a central impact along Y.
    np.testing.assert_allclose(a.centre[1], -b.centre[1], atol=1e-9)
    np.testing.assert_allclose(met.contact.normal, [0.0, 1.0, 0.0], atol=1e-9)


def test_a_sphere_that_goes_alone_meets_nobody() -> None:
    description = WorldDescription(holder=TiltedTubes())
    alone = fire(description, Release(None, 5.0), np.random.default_rng(1))
    assert alone.contact is None
    a, b = alone.poses(0.4)
    assert a is None
    assert b is not None


def dropped(**changes: float) -> Encounter:
    law = ContactLaw(**changes)
    description = WorldDescription(holder=EXACT, environment=VACUUM, contact=law)
    rng = np.random.default_rng(1)
    return drop(description, EXACT, rng, lambda touch: collide(touch, law))


def test_a_dropped_sphere_meets_the_plate_at_the_speed_of_its_fall() -> None:
    contact = dropped().contact
    assert contact is not None
    fallen_m = 0.1 - Sphere().radius_m + 0.05
    assert contact.start_s - EXACT.release_delay_s == pytest.approx(
        math.sqrt(2.0 * fallen_m / 9.81), rel=1e-6
    )
    speed = contact.motions[0][0].velocity[0]
    assert speed == pytest.approx(math.sqrt(2.0 * 9.81 * fallen_m), rel=1e-6)


def test_each_bounce_keeps_the_restitution_and_flies_as_long_as_its_speed_says() -> None:
    found = dropped(restitution=0.7)
    contacts = [found.contact, *found.later][:4]
    for contact, after in pairwise(contacts):
        assert contact is not None
        assert after is not None
        arriving, leaving = (contact.motions[k][0].velocity[0] for k in (0, -1))
        assert -leaving / arriving == pytest.approx(0.7, abs=1e-3)
        assert after.start_s - contact.end_s == pytest.approx(-2.0 * leaving / 9.81, rel=1e-4)


def test_a_bouncing_sphere_is_never_inside_the_plate_by_more_than_it_bends() -> None:
    found = dropped()
    surface = 0.1 - Sphere().radius_m
    depths = [found.poses(t)[0].centre[0] - surface for t in np.arange(0.01, 0.9, 1e-4)]
    assert max(depths) < 2e-4
