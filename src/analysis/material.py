"""What bodies are made of: elasticity, density and yield, stated or by a name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Annotated, Any

from pydantic import BeforeValidator, ConfigDict, Field
from pydantic.dataclasses import dataclass


@dataclass(
    frozen=True, slots=True, config=ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)
)
class Material:
    """A material, the same of both bodies.

    Attributes
    ----------
    youngs_modulus_pa, poissons_ratio
        Of the elastic solid.
    density_kg_per_m3
        None: not stated. The spheres' own densities must not differ from it.
    yield_pa
        Stress at which it yields; None: not stated.
    name
        What it is called; alone, it is one of `NAMED`.
    """

    youngs_modulus_pa: Annotated[float, Field(ge=1e4, le=2e12)]
    poissons_ratio: Annotated[float, Field(ge=0, le=0.5)]
    density_kg_per_m3: Annotated[float, Field(gt=0, le=30_000)] | None = None
    yield_pa: Annotated[float, Field(gt=0, le=1e11)] | None = None
    name: str | None = None

    @property
    def plane_modulus(self) -> float:
        """Return E / (1 - nu^2), Pa."""
        return self.youngs_modulus_pa / (1.0 - self.poissons_ratio**2)

    @property
    def contact_modulus(self) -> float:
        """Return E* of two bodies of this material, Pa: half the plane modulus."""
        return self.plane_modulus / 2.0


NYLON_YIELD_PA = 70e6
NAMED: Mapping[str, Material] = {
    name: Material(modulus, 0.25, 1150.0, NYLON_YIELD_PA, name)
    for name, modulus in (("nylon-soft", 2.3e9), ("nylon-stiff", 3.8e9))
}
"""Table 7.1 of the thesis, at both ends of its range of Young's modulus; what nylon yields at is of
data sheets."""


def _by_name(stated: object) -> object:
    """Return the numbers of a material of which only the name is stated."""
    if not isinstance(stated, Mapping) or set(stated) != {"name"}:
        return stated
    known: dict[str, Any] = {name: asdict(material) for name, material in NAMED.items()}
    if stated["name"] not in known:
        raise ValueError(
            f"name is {stated['name']!r}; known are {', '.join(known)}, or state"
            " youngs_modulus_pa and poissons_ratio"
        )
    return known[stated["name"]]


StatedMaterial = Annotated[Material, BeforeValidator(_by_name)]
"""A material as documents hold it: its numbers, or its name alone."""
