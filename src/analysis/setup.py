"""What is known before a shot: camera, bodies and surroundings, as every document has them.

campaign.toml, the manifest of a shot and the configuration of a rig all hold these tables, with
these units and limits; `setup_of` and `setup_document` read and write them. A value beyond a limit
cannot be made at all.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal, Self

from pydantic import (
    Field,
    SerializerFunctionWrapHandler,
    ValidationInfo,
    field_validator,
    model_serializer,
    model_validator,
)
from pydantic.dataclasses import dataclass

from analysis.material import StatedMaterial
from analysis.schema.codec import STRICT, named, read, written

HOLLOW_SHELL = 0.667
"""I / (m r^2) with all mass at the surface, 2/3 as it is written down; no sphere has more."""
WHOLE_FRAME = (0, 0)
"""Rows of the front view where none are stated."""

Rows = tuple[int, int]
"""Half-open range of image rows [first, past the last)."""
Pixel = tuple[float, float]
"""(row, column); an integer is the centre of a pixel."""
Scale = Annotated[float, Field(gt=0, le=1e9)]
UNSTATED_DIAMETER = 1e-3
"""Relative standard error of a diameter where none is stated: a calliper's, of an inch."""
LEAST_NORMAL = 1e-3
"""Length of a plate's normal below which it has no direction."""


@dataclass(frozen=True, slots=True, config=STRICT)
class CameraSetup:
    """The camera and its two views.

    Attributes
    ----------
    frame_rate_hz
        Frames a second; used where frames carry no times of their own.
    height_px, width_px
        Size of a frame.
    front_view_rows, top_view_rows
        Half-open ranges of rows. No front view: the whole frame. No top view: None, and Z is taken
        as constant.
    scale_px_per_m
        None: taken from the spheres' diameter in the images.
    front_origin_px, top_origin_px
        (row, column) where X = Y = Z = 0 appears; None: the centre of the view.
    exposure_s
        Time the shutter is open, centred on a frame's time; None: not stated.
    """

    frame_rate_hz: Annotated[float, Field(gt=0, le=1e9)]
    height_px: Annotated[int, Field(ge=8, le=65536)]
    width_px: Annotated[int, Field(ge=8, le=65536)]
    front_view_rows: Annotated[Rows, Field(validate_default=True)] = WHOLE_FRAME
    top_view_rows: Rows | None = None
    scale_px_per_m: Scale | None = None
    front_origin_px: Pixel | None = None
    top_origin_px: Pixel | None = None
    exposure_s: Annotated[float, Field(ge=0, le=60)] | None = None

    @field_validator("front_view_rows", "top_view_rows")
    @classmethod
    def _within_the_frame(cls, rows: Rows | None, info: ValidationInfo) -> Rows | None:
        height = info.data.get("height_px")
        if rows is None or height is None:
            return rows
        if rows == WHOLE_FRAME and info.field_name == "front_view_rows":
            return 0, height
        if not 0 <= rows[0] < rows[1] <= height:
            raise ValueError(f"{list(rows)} is not a half-open range of rows within 0 to {height}")
        return rows

    @field_validator("top_view_rows")
    @classmethod
    def _beside_the_front_view(cls, rows: Rows | None, info: ValidationInfo) -> Rows | None:
        # A fault of the front view itself has its own message.
        front = info.data.get("front_view_rows")
        if rows is not None and front is not None and rows[0] < front[1] and front[0] < rows[1]:
            raise ValueError(f"{list(rows)} overlaps front_view_rows {list(front)}")
        return rows


@dataclass(frozen=True, slots=True, config=STRICT)
class SphereSetup:
    """One sphere: diameter in m, density in kg/m^3, inertia factor I / (m r^2).

    A plate stands still, has no diameter (0 here), and comes only as sphere b.

    Attributes
    ----------
    normal
        Of a plate, from the sphere into it, rig axes, of any length; None: not stated.
    diameter_sigma_m
        Standard error of the diameter, which is what lengths are measured by where no scale is
        stated; None: not stated (`UNSTATED_DIAMETER`).
    """

    name: Literal["a", "b"]
    diameter_m: Annotated[float, Field(gt=0, le=1)] = 0.0
    density_kg_per_m3: Annotated[float, Field(gt=0, le=30_000)] = 1150.0
    inertia_factor: Annotated[float, Field(gt=0, le=HOLLOW_SHELL)] = 0.4
    plate: bool = False
    normal: tuple[float, float, float] | None = None
    diameter_sigma_m: Annotated[float, Field(ge=0, le=0.1)] | None = None

    @field_validator("normal")
    @classmethod
    def _has_a_direction(
        cls, normal: tuple[float, float, float] | None
    ) -> tuple[float, float, float] | None:
        if normal is not None and math.hypot(*normal) < LEAST_NORMAL:
            raise ValueError(f"{list(normal)} has no direction")
        return normal

    @model_validator(mode="after")
    def _is_a_sphere_or_plate_b(self) -> Self:
        if self.plate and self.name == "a":
            raise ValueError("a plate comes only as sphere b")
        if self.normal is not None and not self.plate:
            raise ValueError(f"normal is that of a plate, and {self.name!r} is none")
        if not self.plate and self.diameter_m == 0.0:
            raise ValueError(f"diameter_m is missing for sphere {self.name!r}")
        return self

    @model_serializer(mode="wrap")
    def _fields(self, inner: SerializerFunctionWrapHandler) -> dict[str, Any]:
        fields: dict[str, Any] = inner(self)
        if self.plate:
            stated = {} if self.normal is None else {"normal": fields["normal"]}
            return {"name": self.name, "plate": True, **stated}
        return {name: value for name, value in fields.items() if name not in {"plate", "normal"}}

    @property
    def diameter_sigma(self) -> float:
        """Relative standard error of the diameter; 0 for a plate."""
        if self.plate:
            return 0.0
        if self.diameter_sigma_m is None:
            return UNSTATED_DIAMETER
        return self.diameter_sigma_m / self.diameter_m


DRAG_SIGMA = 0.2
"""Standard error of a stated drag coefficient where none is stated with it."""


@dataclass(frozen=True, slots=True, config=STRICT)
class Environment:
    """Surroundings of the flight.

    Attributes
    ----------
    gravity_m_per_s2
        Along +X, down.
    drag_coefficient, drag_coefficient_sigma
        Of the spheres in air, F = rho/2 Cd A v^2, with its standard error; None: not stated.
    """

    gravity_m_per_s2: Annotated[float, Field(ge=-100, le=100)] = 9.80665
    air_density_kg_per_m3: Annotated[float, Field(ge=0, le=2000)] = 1.2
    drag_coefficient: Annotated[float, Field(ge=0, le=10)] | None = None
    drag_coefficient_sigma: Annotated[float, Field(ge=0, le=10)] = DRAG_SIGMA


MEMORY_RAD = 0.3
"""Of the thesis's markers, 4 mm on a sphere of an inch."""


@dataclass(frozen=True, slots=True, config=STRICT)
class SlowErrors:
    """Errors of poses that last for a flight or a campaign, so that no scatter shows them.

    Attributes
    ----------
    position_m, rotation_rad
        Size of what the frames of one flight share, of a coordinate and about each axis; 0: none
        is stated.
    shared_m
        Size of what all flights of a sphere share in a campaign, of a coordinate, where it is more
        than `position_m`: no scatter of flights shows it.
    shared_rad
        The same of orientations; 0: larger than `rotation_rad` as `shared_m` is than `position_m`.
    depth_m
        `position_m` of Z alone, which another view or a mirror shows; 0: as of X and Y. Fits of a
        campaign take it; a shot by itself is measured with `position_m` along all axes.
    varying
        Share of that, of places and of turns, which changes with the place in the field.
    scale
        Relative standard error of the images' scale, by which lengths of all shots come out too
        long or too short together; 0: none is stated.
    one_body_frame
        Whether each sphere has one body frame in all shots, so that all shots share the offset of
        the marker pattern from its sphere.
    memory_rad
        By how much a sphere turns while what the frames of a flight share lasts: what its markers
        are wide.
    """

    position_m: Annotated[float, Field(ge=0), named("slow_position_m", "position_m")] = 0.0
    rotation_rad: Annotated[float, Field(ge=0), named("slow_rotation_rad", "rotation_rad")] = 0.0
    shared_m: Annotated[float, Field(ge=0), named("slow_shared_m", "shared_m")] = 0.0
    shared_rad: Annotated[float, Field(ge=0), named("slow_shared_rad", "shared_rad")] = 0.0
    depth_m: Annotated[float, Field(ge=0), named("slow_depth_m", "depth_m")] = 0.0
    varying: Annotated[float, Field(ge=0), named("slow_varying", "varying")] = 1.0
    scale: Annotated[float, Field(ge=0), named("scale_sigma", "scale")] = 0.0
    one_body_frame: bool = True
    memory_rad: Annotated[float, Field(gt=0), named("slow_memory_rad", "memory_rad")] = MEMORY_RAD

    @property
    def stated(self) -> bool:
        """Whether any is larger than zero."""
        return self.common_m > 0 or self.common_rad > 0 or self.scale > 0

    @property
    def sizes(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Sizes of what the frames of a flight share along and about X, Y and Z, m and rad."""
        places = self.position_m, self.position_m, self.depth_m or self.position_m
        return places, (self.rotation_rad, self.rotation_rad, self.rotation_rad)

    @property
    def common_m(self) -> float:
        """Size of what all flights of a sphere share, of a coordinate, m."""
        return max(self.position_m, self.depth_m, self.shared_m)

    @property
    def common_rad(self) -> float:
        """The same of orientations, rad: unless stated, larger than of one flight by as much."""
        if self.shared_rad > 0:
            return max(self.shared_rad, self.rotation_rad)
        shared_m = max(self.position_m, self.shared_m)
        enlarged = shared_m / self.position_m if self.position_m > 0 else 1.0
        return enlarged * self.rotation_rad

    @property
    def varying_m(self) -> float:
        """Size of what of it changes with the place, of a coordinate, m."""
        return self.varying * self.common_m

    @property
    def varying_rad(self) -> float:
        """The same of orientations, rad."""
        return self.varying * self.common_rad

    @property
    def between_m(self) -> float:
        """Size of what the spheres' places share against each other, m: either errs by itself."""
        return math.sqrt(2.0) * self.common_m

    @property
    def between_rad(self) -> float:
        """The same of orientations, rad."""
        return math.sqrt(2.0) * self.common_rad


NO_SLOW_ERRORS = SlowErrors()


@dataclass(frozen=True, slots=True, config=STRICT)
class Setup:
    """Everything a shot's analysis needs beside its frames.

    Attributes
    ----------
    spheres
        a and b.
    measurement
        Slow errors of poses that were measured elsewhere.
    material
        What both bodies are made of; None: not stated.
    """

    camera: CameraSetup
    spheres: tuple[SphereSetup, SphereSetup]
    environment: Environment = Environment()
    measurement: SlowErrors = NO_SLOW_ERRORS
    material: StatedMaterial | None = None

    @field_validator("spheres")
    @classmethod
    def _one_of_each_name(
        cls, spheres: tuple[SphereSetup, SphereSetup]
    ) -> tuple[SphereSetup, SphereSetup]:
        first, second = sorted(spheres, key=lambda sphere: sphere.name)
        if first.name == second.name:
            raise ValueError(f"both are named {first.name!r}; name them 'a' and 'b'")
        return first, second

    @model_validator(mode="after")
    def _has_the_density_of_its_material(self) -> Self:
        density = None if self.material is None else self.material.density_kg_per_m3
        for sphere in self.spheres:
            own = sphere.density_kg_per_m3
            if density is not None and not sphere.plate and abs(own / density - 1.0) > SAME_DENSITY:
                raise ValueError(
                    f"sphere {sphere.name} has {own:g} kg/m^3 and its material {density:g}"
                )
        return self

    @property
    def length_sigma(self) -> float:
        """Relative standard error of what lengths are measured by: the diameters, or nothing.

        Both are measured with one tool, and err together. A stated scale is taken as it is.
        """
        if self.camera.scale_px_per_m is not None:
            return 0.0
        moving = [sphere.diameter_sigma for sphere in self.spheres if not sphere.plate]
        return sum(moving) / len(moving)

    @property
    def stated_length_sigma(self) -> float:
        """The same where the set-up states it, 0 where it does not."""
        moving = [sphere for sphere in self.spheres if not sphere.plate]
        return self.length_sigma if all(s.diameter_sigma_m is not None for s in moving) else 0.0


SAME_DENSITY = 0.05
"""Relative: a sphere's density, weighed, and that of its material as tables have it."""


def setup_of(document: Mapping[str, Any]) -> Setup:
    """Return the set-up that a document holds; arrays may be lists.

    Raises
    ------
    pydantic.ValidationError
        A key is unknown, missing, or out of its range.
    """
    return read(Setup, document)


def setup_document(setup: Setup) -> dict[str, Any]:
    """Return a set-up as documents hold it, without fields that are not known."""
    return written(setup, leave_out_none=True)


def without_exposure(setup: Setup) -> Setup:
    """Return the set-up as all shots share it: the exposure may change from one to the next."""
    return replace(setup, camera=replace(setup.camera, exposure_s=None))
