"""The world of a configuration: its spheres, surroundings, camera, contact and tubes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, TypeVar

from simulators.world.description import ContactLaw, Environment, Sphere, Tube, WorldDescription
from simulators.world.optics import Optics

Table = Mapping[str, Any]
Part = TypeVar("Part", ContactLaw, Tube, Environment)

_CONTACT_LIMITS = {
    "youngs_modulus_pa": (1e5, 1e12),
    "poissons_ratio": (0.0, 0.5),
    "restitution": (0.01, 0.999),
    "friction": (0.0, 2.0),
    "tangential_stiffness_ratio": (0.01, 1.0),
    "tangential_damping_ratio": (0.0, 1.0),
}
_TUBE_LIMITS = {
    "mouth_m": (0.01, 1.0),
    "height_m": (-0.1, 0.1),
    "piston_area_m2": (1e-7, 1e-2),
    "stroke_m": (1e-4, 0.5),
    "friction_n": (0.0, 100.0),
    "valve_delay_s": (0.0, 0.1),
    "valve_jitter_s": (0.0, 0.01),
    "speed_scatter": (0.0, 0.5),
    "direction_scatter_rad": (0.0, 0.2),
    "position_scatter_m": (0.0, 0.01),
    "spin_scatter_rad_per_s": (0.0, 1000.0),
}
_AIR_LIMITS = {"drag_coefficient": (0.0, 2.0)}


def described(
    scene: Table,
    *,
    contact: Table | None = None,
    tube: Table | None = None,
    air: Table | None = None,
) -> WorldDescription:
    """Return the world of a scene, with what only the world knows of contact, tubes and air.

    Parameters
    ----------
    scene
        What the configuration says of the rig: `spheres` (two tables), `environment`, `optics`,
        `exposure_us`; what is absent is the nylon rig's. Its drag coefficient is what the rig
        believes; that of the world is in `air`.
    contact, tube, air
        Fields of `ContactLaw`, `Tube`, and `drag_coefficient`, where they differ from nylon's.

    Raises
    ------
    ValueError
        An unknown field, a number outside its limits, or a body that is no sphere; it is named.
    """
    nylon = WorldDescription()
    bodies = scene.get("spheres", ({}, {}))
    a, b = (_sphere(body) for body in bodies)
    surroundings = scene.get("environment", {})
    environment = replace(
        nylon.environment,
        gravity_m_per_s2=surroundings.get("gravity_m_per_s2", 9.80665),
        air_density_kg_per_m3=surroundings.get("air_density_kg_per_m3", 1.2),
    )
    return WorldDescription(
        sphere_a=a,
        sphere_b=b,
        tube=_with(nylon.tube, "tube", tube or {}, _TUBE_LIMITS),
        contact=_with(nylon.contact, "contact", contact or {}, _CONTACT_LIMITS),
        environment=_with(environment, "air", air or {}, _AIR_LIMITS),
        optics=_optics(nylon.optics, scene.get("optics", {}), scene.get("exposure_us")),
    )


def _sphere(body: Table) -> Sphere:
    if body.get("plate"):
        raise ValueError("sphere b is a plate, and the simulated tubes fire spheres")
    known = ("diameter_m", "density_kg_per_m3", "inertia_factor")
    stated: dict[str, Any] = {name: float(body[name]) for name in known if name in body}
    return replace(Sphere(), **stated)


def _optics(nylon: Optics, optics: Table, exposure_us: float | None) -> Optics:
    """Return camera and mirror as the configuration states them; what it leaves open is nylon's."""
    names = {
        "front_view_rows": "front_rows",
        "top_view_rows": "top_rows",
        "front_origin_px": "front_origin_px",
        "top_origin_px": "top_origin_px",
    }
    stated: dict[str, Any] = {
        ours: tuple(optics[theirs])
        for theirs, ours in names.items()
        if optics.get(theirs) is not None
    }
    if optics.get("scale_px_per_m") is not None:
        stated["scale_px_per_m"] = float(optics["scale_px_per_m"])
    if exposure_us is not None:
        stated["exposure_s"] = exposure_us * 1e-6
    return replace(nylon, **stated)


def _with(part: Part, name: str, table: Table, limits: Mapping[str, tuple[float, float]]) -> Part:
    known = {field.name for field in fields(part)} & limits.keys()
    for key, value in table.items():
        if key not in known:
            raise ValueError(
                f"simulation.{name}.{key} is no field; there are {', '.join(sorted(known))}"
            )
        low, high = limits[key]
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not is_number or not math.isfinite(value) or not low <= value <= high:
            raise ValueError(f"simulation.{name}.{key} is {value!r}; allowed {low} to {high}")
    stated: dict[str, Any] = {key: float(value) for key, value in table.items()}
    return replace(part, **stated)
