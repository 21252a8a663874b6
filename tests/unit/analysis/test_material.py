"""A stated material: its numbers, its name, and what it makes of a contact."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import solve_ivp

from analysis.collision.contact_frames import longest_contact
from analysis.collision.force_law import stated_modulus, yield_speed
from analysis.document import expected
from analysis.scene import bodies_of
from analysis.setup import Setup, setup_document, setup_of

CAMERA = {"frame_rate_hz": 1000.0, "height_px": 192, "width_px": 240}
STEEL = {"youngs_modulus_pa": 206e9, "poissons_ratio": 0.3}


def setup(material: object, density: float = 1150.0, *, plate: bool = False) -> Setup:
    ball = {"diameter_m": 0.0254, "density_kg_per_m3": density}
    other = {"name": "b", "plate": True} if plate else {"name": "b", **ball}
    spheres = [{"name": "a", **ball}, other]
    return setup_of({"camera": CAMERA, "spheres": spheres, "material": material})


def test_a_name_stands_for_the_numbers_of_table_7_1() -> None:
    material = setup({"name": "nylon-stiff"}).material
    assert material is not None
    assert (material.youngs_modulus_pa, material.poissons_ratio) == (3.8e9, 0.25)
    assert material.density_kg_per_m3 == 1150.0


def test_a_material_reads_back_from_the_document_that_holds_it() -> None:
    known = setup({"name": "nylon-soft"})
    assert setup_of(json.loads(json.dumps(setup_document(known)))) == known
    assert "material" not in setup_document(setup(None))


@pytest.mark.parametrize(
    ("material", "density", "said"),
    [
        ({"name": "jelly"}, 1150.0, "nylon-soft, nylon-stiff"),
        ({"name": "nylon-soft"}, 7830.0, "7830"),
        ({"youngs_modulus_pa": 1e9}, 1150.0, "poissons_ratio"),
        (STEEL | {"poissons_ratio": 0.7}, 1150.0, "less than or equal to 0.5"),
        (STEEL | {"yield": 1e8}, 1150.0, "yield"),
    ],
)
def test_what_no_material_can_be_is_refused(material: object, density: float, said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        setup(material, density)


@pytest.mark.parametrize("plate", [False, True])
def test_steel_touches_as_long_as_its_integrated_contact(plate: bool) -> None:
    bodies = bodies_of(setup(STEEL, 7830.0, plate=plate))
    mass = 7830.0 * math.pi / 6 * 0.0254**3
    reduced, radius = (mass, 0.0127) if plate else (mass / 2, 0.0127 / 2)
    stiffness = 4 / 3 * (206e9 / (2 * (1 - 0.3**2))) * math.sqrt(radius)

    def motion(_: float, state: np.ndarray) -> list[float]:
        return [state[1], -stiffness * max(state[0], 0.0) ** 1.5 / reduced]

    def parted(_: float, state: np.ndarray) -> float:
        return state[0] if state[1] < 0 else 1.0

    parted.terminal = True  # type: ignore[attr-defined]
    done = solve_ivp(motion, (0, 1e-3), [0.0, 2.0], events=parted, rtol=1e-9, atol=1e-18)
    [closed] = longest_contact(np.array([2.0]), bodies)
    assert closed == pytest.approx(float(done.t[-1]), rel=2e-3)
    made = expected(bodies, -2.0)
    assert made is not None
    assert made.contact_duration_s == pytest.approx(closed, rel=1e-9)
    assert made.yield_speed_m_per_s is None


def test_without_a_material_contacts_last_as_soft_nylons_and_nothing_is_expected() -> None:
    nobody, nylon = bodies_of(setup(None)), bodies_of(setup({"name": "nylon-soft"}))
    speed = np.array([1.0])
    assert longest_contact(speed, nobody) == pytest.approx(longest_contact(speed, nylon))
    assert stated_modulus(nobody) is None
    assert expected(nobody, -1.0) is None


def test_nylon_yields_where_the_mean_pressure_of_hertz_reaches_it() -> None:
    # Yield begins where the largest pressure is 1.6 Y (Johnson, section 6.2): with
    # p0 = (6 F E*^2 / pi^3 R^2)^(1/3) and the energy of the compression, m* v^2 / 2 = (2/5) F x.
    bodies = bodies_of(setup({"name": "nylon-soft"}))
    stress, modulus = 70e6, 2.3e9 / (2 * (1 - 0.25**2))
    radius, mass = 0.0127 / 2, 1150.0 * math.pi / 6 * 0.0254**3 / 2
    force = (1.6 * stress) ** 3 * math.pi**3 * radius**2 / (6 * modulus**2)
    depth = (9 * force**2 / (16 * radius * modulus**2)) ** (1 / 3)
    speed = math.sqrt(2 * 0.4 * force * depth / mass)
    assert yield_speed(bodies) == pytest.approx(speed, rel=0.02)
