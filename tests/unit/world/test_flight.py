import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from simulators.world.description import Environment, Sphere
from simulators.world.flight import fly
from simulators.world.rotation import matrix
from simulators.world.state import Motion

Triple = tuple[float, float, float]
VACUUM = Environment(air_density_kg_per_m3=0.0)
SPHERE = Sphere()
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def moving(centre: Triple, velocity: Triple, spin: Triple = (0.0, 0.0, 0.0)) -> Motion:
    return Motion(np.array(centre), np.array(velocity), UPRIGHT, np.array(spin))


def test_without_air_a_sphere_follows_a_parabola() -> None:
    flight = fly([moving((0.01, -0.08, 0.0), (0.02, 1.4, -0.01))], [SPHERE], 0.02, 0.3, VACUUM)
    for time in (0.02, 0.07, 0.19, 0.3):
        since = time - 0.02
        (motion,) = flight.at(time)
        fall = np.array([0.5 * 9.80665 * since**2, 0.0, 0.0])
        expected = np.array([0.01, -0.08, 0.0]) + np.array([0.02, 1.4, -0.01]) * since + fall
        np.testing.assert_allclose(motion.centre, expected, atol=1e-12)
        np.testing.assert_allclose(motion.velocity[0], 0.02 + 9.80665 * since, rtol=1e-12)


def test_drag_alone_slows_as_its_closed_form() -> None:
    air = Environment(gravity_m_per_s2=0.0, air_density_kg_per_m3=1.2, drag_coefficient=0.4)
    flight = fly([moving((0.0, 0.0, 0.0), (0.0, 3.0, 0.0))], [SPHERE], 0.0, 0.3, air)
    (motion,) = flight.at(0.3)
    # m dv/dt = -c v^2 gives v = v0 / (1 + c v0 t / m) and y = m/c ln(1 + c v0 t / m).
    per_metre = 0.5 * 1.2 * 0.4 * np.pi * 0.0127**2 / (1150.0 * 4.0 / 3.0 * np.pi * 0.0127**3)
    assert motion.velocity[1] == pytest.approx(3.0 / (1.0 + per_metre * 3.0 * 0.3), rel=1e-10)
    assert motion.centre[1] == pytest.approx(np.log1p(per_metre * 3.0 * 0.3) / per_metre, rel=1e-10)


def test_a_spinning_sphere_turns_steadily_about_rig_axes() -> None:
    spin = (3.0, -20.0, 11.0)
    flight = fly([moving((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), spin)], [SPHERE], 1.0, 1.2, VACUUM)
    turned = Rotation.from_rotvec(np.array(spin) * 0.15).as_matrix()
    np.testing.assert_allclose(matrix(flight.pose(0, 1.15).orientation), turned, atol=1e-13)


def test_spheres_touch_when_the_quadratic_equation_says_so() -> None:
    a = moving((-0.004, -0.08, 0.001), (0.0, 1.4, 0.003))
    b = moving((0.004, 0.08, -0.002), (0.0, -1.3, 0.001))
    flight = fly([a, b], [SPHERE, SPHERE], 0.0, 0.3, VACUUM)
    # Gravity is common to both: the relative motion is uniform, |p + u t|^2 = D^2.
    p, u = b.centre - a.centre, b.velocity - a.velocity
    quadratic = [u @ u, 2.0 * (p @ u), p @ p - 0.0254**2]
    assert flight.touch_s == pytest.approx(min(np.roots(quadratic)), abs=1e-12)


@pytest.mark.parametrize(("overlap", "touches"), [(1e-9, True), (-1e-9, False)])
def test_a_graze_of_a_nanometre_is_not_missed(overlap: float, touches: bool) -> None:
    a = moving((0.0, -0.08, 0.0), (0.0, 2.0, 0.0))
    b = moving((0.0254 - overlap, 0.08, 0.0), (0.0, -2.0, 0.0))
    flight = fly([a, b], [SPHERE, SPHERE], 0.0, 0.3, VACUUM)
    assert (flight.touch_s is not None) is touches


def test_spheres_that_part_do_not_touch() -> None:
    a = moving((0.0, -0.02, 0.0), (0.0, -2.0, 0.0))
    b = moving((0.0, 0.02, 0.0), (0.0, 2.0, 0.0))
    assert fly([a, b], [SPHERE, SPHERE], 0.0, 0.3, VACUUM).touch_s is None
