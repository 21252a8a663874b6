"""The world of a configuration: its spheres, surroundings, camera, contact and tubes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from simulators.world.description import (
    ContactLaw,
    Environment,
    Magnet,
    Sphere,
    TiltedTubes,
    Tube,
    WorldDescription,
)
from simulators.world.optics import Optics, picture_rows

NO_MIRROR_PX = (-1.0e4, -1.0e4)
"""Where a camera without a mirror shows the top view: far outside its frame."""
Table = Mapping[str, Any]
Part = TypeVar("Part", ContactLaw, Tube, TiltedTubes, Magnet, Environment)

_CONTACT_LIMITS = {
    "youngs_modulus_pa": (1e5, 1e12),
    "poissons_ratio": (0.0, 0.5),
    "restitution": (0.01, 0.999),
    "friction": (0.0, 2.0),
    "tangential_stiffness_ratio": (0.01, 1.0),
    "tangential_damping_ratio": (0.0, 1.0),
}
_TUBE_LIMITS = {
    "mouth_m": (0.001, 1.0),
    "height_m": (-0.1, 0.1),
    "piston_area_m2": (1e-9, 1e-2),
    "stroke_m": (1e-4, 0.5),
    "friction_n": (0.0, 100.0),
    "valve_delay_s": (0.0, 0.1),
    "valve_jitter_s": (0.0, 0.01),
    "speed_scatter": (0.0, 0.5),
    "direction_scatter_rad": (0.0, 0.2),
    "position_scatter_m": (0.0, 0.01),
    "spin_scatter_rad_per_s": (0.0, 1000.0),
}
_TILTED_LIMITS = {
    "mouth_m": (0.001, 1.0),
    "height_m": (-0.5, 0.5),
    "length_m": (1e-3, 2.0),
    "angle_a_deg": (0.0, 90.0),
    "angle_b_deg": (0.0, 90.0),
    "release_delay_s": (0.0, 0.1),
    "release_jitter_s": (0.0, 0.01),
    "speed_scatter": (0.0, 0.5),
    "direction_scatter_rad": (0.0, 0.2),
    "position_scatter_m": (0.0, 0.01),
    "spin_scatter_rad_per_s": (0.0, 1000.0),
}
_MAGNET_LIMITS = {
    "height_m": (-1.0, 1.0),
    "plate_m": (-1.0, 10.0),
    "release_delay_s": (0.0, 0.1),
    "release_jitter_s": (0.0, 0.01),
    "position_scatter_m": (0.0, 0.01),
    "drift_scatter_m_per_s": (0.0, 1.0),
    "spin_scatter_rad_per_s": (0.0, 1000.0),
}
_AIR_LIMITS = {"drag_coefficient": (0.0, 2.0)}
DRAG_SCATTER = 0.02
"""Of the drag coefficients of smooth spheres about 0.40 at Reynolds numbers of 1500 to 5000."""


def described(
    scene: Table,
    *,
    contact: Table | None = None,
    tube: Table | None = None,
    magnet: Table | None = None,
    air: Table | None = None,
    rng: np.random.Generator | None = None,
) -> WorldDescription:
    """Return the world of a scene, with what only the world knows of contact, tubes and air.

    Parameters
    ----------
    scene
        What the configuration says of the rig: `apparatus`, `spheres` (two tables), `material`,
        `environment`, `optics`, `rows` of a picture, `exposure_us`; what is absent is the nylon
        rig's with pushers. Its drag coefficient is what the rig believes; that of the world is in
        `air`.
    contact, tube, magnet, air
        Fields of `ContactLaw`, of `Tube` (`TiltedTubes` on the release apparatus), of `Magnet` (on
        the drop apparatus), and `drag_coefficient`, where they differ from nylon's.
    rng
        Of the true diameters, where their standard errors are stated: both are measured with one
        tool, and off by as many errors. Of the drag coefficient, where `air` does not give it.
        None: diameters are as stated, and the drag coefficient is 0.40.

    Raises
    ------
    ValueError
        An unknown field, a number outside its limits, a body or a table that the apparatus cannot
        have; it is named.
    """
    nylon = WorldDescription()
    apparatus = scene.get("apparatus", "pusher")
    off = 0.0 if rng is None else float(rng.normal())
    slowed = 0.0 if rng is None else DRAG_SCATTER * float(rng.normal())
    bodies = [_as_it_is(body, off) for body in scene.get("spheres", ({}, {}))]
    a, b = _bodies(apparatus, bodies)
    surroundings = scene.get("environment", {})
    environment = replace(
        nylon.environment,
        gravity_m_per_s2=surroundings.get("gravity_m_per_s2", 9.80665),
        air_density_kg_per_m3=surroundings.get("air_density_kg_per_m3", 1.2),
        drag_coefficient=nylon.environment.drag_coefficient + slowed,
    )
    return WorldDescription(
        sphere_a=a,
        sphere_b=b,
        **_launcher(apparatus, tube or {}, magnet or {}),
        contact=_with(_of_material(scene), "contact", contact or {}, _CONTACT_LIMITS),
        environment=_with(environment, "air", air or {}, _AIR_LIMITS),
        optics=_optics(nylon.optics, scene.get("optics", {}), scene),
    )


def _of_material(scene: Table) -> ContactLaw:
    """Return nylon's contact, elastic as the stated material."""
    material = scene.get("material") or {}
    names = ("youngs_modulus_pa", "poissons_ratio")
    return replace(ContactLaw(), **{name: material[name] for name in names if name in material})


def _launcher(apparatus: str, tube: Table, magnet: Table) -> dict[str, Any]:
    """Return `tube` or `holder` of the description, whichever the apparatus has."""
    if apparatus == "drop":
        if tube:
            raise ValueError("simulation.tube is given, and the drop apparatus has a magnet")
        return {"holder": _with(Magnet(), "magnet", magnet, _MAGNET_LIMITS)}
    if magnet:
        raise ValueError(f"simulation.magnet is given, and the {apparatus} apparatus has tubes")
    if apparatus == "release":
        return {"holder": _with(TiltedTubes(), "tube", tube, _TILTED_LIMITS)}
    return {"tube": _with(Tube(), "tube", tube, _TUBE_LIMITS)}


def _bodies(apparatus: str, bodies: Sequence[Table]) -> tuple[Sphere, Sphere]:
    a, b = bodies
    if b.get("plate") and apparatus != "drop":
        raise ValueError(f"sphere b is a plate, and the {apparatus} apparatus fires two spheres")
    if apparatus == "drop" and not b.get("plate"):
        raise ValueError("sphere b is no plate, and a magnet drops one sphere on a plate")
    if apparatus == "drop":
        # Nothing measures how a dropped sphere turns: it is plain.
        return replace(_sphere(a), markers=0), Sphere()
    return _sphere(a), _sphere(b)


def _as_it_is(body: Table, off: float) -> Table:
    """Return a body with its true diameter, so many stated errors off what is stated."""
    if not body.get("diameter_sigma_m"):
        return body
    return {**body, "diameter_m": body["diameter_m"] + off * body["diameter_sigma_m"]}


def _sphere(body: Table) -> Sphere:
    known = ("diameter_m", "density_kg_per_m3", "inertia_factor")
    stated: dict[str, Any] = {name: float(body[name]) for name in known if name in body}
    return replace(Sphere(), **stated)


def _optics(nylon: Optics, optics: Table, scene: Table) -> Optics:
    """Return camera and mirror as the configuration states them; what it leaves open is nylon's.

    A split picture holds the middle rows of the frame, and the camera is aimed so that the origin
    lies where the configuration says that it lies in the picture, or else in its middle.
    """
    rows = scene.get("rows") or nylon.rows
    first = picture_rows(nylon, rows)[0] if rows < nylon.rows else 0
    stated: dict[str, Any] = {
        ours: tuple(optics[theirs])
        for theirs, ours in (("front_view_rows", "front_rows"), ("top_view_rows", "top_rows"))
        if optics.get(theirs) is not None
    }
    if first:
        stated["front_origin_px"] = ((nylon.rows - 1) / 2.0, nylon.front_origin_px[1])
    for name in ("front_origin_px", "top_origin_px"):
        if optics.get(name) is not None:
            row, column = optics[name]
            stated[name] = (row + first, column)
    if optics.get("scale_px_per_m") is not None:
        stated["scale_px_per_m"] = float(optics["scale_px_per_m"])
    if optics.get("front_view_rows") is not None and optics.get("top_view_rows") is None:
        stated["top_origin_px"] = NO_MIRROR_PX
    if scene.get("exposure_us") is not None:
        stated["exposure_s"] = scene["exposure_us"] * 1e-6
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
