"""What the camera sees and what collides: views, spheres, surroundings."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from analysis.setup import DRAG_SIGMA
from rigctl.config.model import Rows, StrictModel

Pixel = tuple[float, float]
"""(row, column); an integer is the centre of a pixel."""


class Optics(StrictModel):
    """Where the two views lie in the frame and where X = Y = Z = 0 appears in each.

    Without top-view keys the rig has no mirror. A missing scale is taken from the spheres'
    diameter in the images, a missing origin is chosen by the analysis.
    """

    front_view_rows: Rows
    top_view_rows: Rows | None = None
    front_origin_px: Pixel | None = None
    top_origin_px: Pixel | None = None
    scale_px_per_m: float | None = Field(default=None, gt=0)

    @model_validator(mode="after")
    def _views_apart(self) -> Self:
        if self.top_view_rows is None:
            if self.top_origin_px is not None:
                raise ValueError("top_origin_px is given without top_view_rows")
            return self
        front, top = self.front_view_rows, self.top_view_rows
        if front[0] < top[1] and top[0] < front[1]:
            raise ValueError(f"front_view_rows {list(front)} and top_view_rows {list(top)} overlap")
        return self


class Sphere(StrictModel):
    """One sphere; `inertia_factor` is I / (m r^2), 0.4 for a solid one."""

    name: Literal["a", "b"]
    diameter_m: float = Field(gt=0, le=1)
    density_kg_per_m3: float = Field(gt=0, le=30_000)
    inertia_factor: float = Field(gt=0, le=2 / 3, description="2/3 is a thin shell")


class Plate(StrictModel):
    """A flat surface in the place of sphere b."""

    name: Literal["b"]
    plate: Literal[True]


def _body(value: object) -> str:
    plate = isinstance(value, Plate) or (isinstance(value, dict) and "plate" in value)
    return "plate" if plate else "sphere"


Body = Annotated[
    Annotated[Sphere, Tag("sphere")] | Annotated[Plate, Tag("plate")], Discriminator(_body)
]


class Environment(StrictModel):
    """Surroundings of the flight."""

    gravity_m_per_s2: float = Field(ge=0, le=20)
    air_density_kg_per_m3: float = Field(ge=0, le=10)
    drag_coefficient: float | None = Field(
        default=None, ge=0, le=10, description="of the spheres in air: F = rho/2 Cd A v^2"
    )
    drag_coefficient_sigma: float = Field(default=DRAG_SIGMA, ge=0, le=10)
