"""campaign.toml: camera, spheres and surroundings of a campaign."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, TypeVar

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
)

from analysis.errors import InputError
from analysis.exchange.faults import fault
from analysis.files import read_toml
from analysis.setup import DRAG_SIGMA, MEMORY_RAD, CameraSetup, Setup, SlowErrors, SphereSetup

FORMAT = 1
N = TypeVar("N", int, float)

LARGEST_DIAMETER_M = 0.5
HOLLOW_SHELL = 0.667
"""I / (m r^2) with all mass at the surface, 2/3 as it is written down; no sphere has more."""

Positive = Annotated[float, Field(gt=0)]
Rows = Annotated[list[int], Field(min_length=2, max_length=2)]
Pixel = Annotated[list[float], Field(min_length=2, max_length=2)]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


class _Camera(_Strict):
    frame_rate_hz: Positive
    width_px: Annotated[int, Field(ge=16)]
    height_px: Annotated[int, Field(ge=16)]
    scale_px_per_m: Positive | None = None
    front_view_rows: Rows | None = None
    top_view_rows: Rows | None = None
    front_origin_px: Pixel | None = None
    top_origin_px: Pixel | None = None

    @field_validator("front_view_rows", "top_view_rows")
    @classmethod
    def _within_the_frame(cls, rows: list[int] | None, info: ValidationInfo) -> list[int] | None:
        height = info.data.get("height_px")
        if rows is not None and height is not None and not 0 <= rows[0] < rows[1] <= height:
            raise ValueError(f"{rows} is not a half-open range of rows within 0 to {height}")
        return rows

    @field_validator("top_view_rows")
    @classmethod
    def _beside_the_front_view(
        cls, rows: list[int] | None, info: ValidationInfo
    ) -> list[int] | None:
        # Where one of the two is at fault itself, that is said already.
        if rows is None or not {"height_px", "front_view_rows"} <= info.data.keys():
            return rows
        front = info.data["front_view_rows"] or [0, info.data["height_px"]]
        if rows[0] < front[1] and front[0] < rows[1]:
            raise ValueError(f"{rows} overlaps front_view_rows {front}")
        return rows


class _Sphere(_Strict):
    name: Literal["a", "b"]
    plate: bool = False
    diameter_m: Annotated[float | None, Field(validate_default=True)] = None
    density_kg_per_m3: Positive = 1150.0
    inertia_factor: Annotated[float, Field(gt=0, le=HOLLOW_SHELL)] = 0.4

    @field_validator("diameter_m")
    @classmethod
    def _of_a_sphere(cls, diameter: float | None, info: ValidationInfo) -> float | None:
        if diameter is None:
            if info.data.get("plate"):
                return None
            raise ValueError(f"is missing for sphere {info.data.get('name')!r}")
        if diameter <= 0:
            raise ValueError(f"is out of range (found {diameter}, allowed more than 0)")
        if diameter > LARGEST_DIAMETER_M:
            raise ValueError(
                f"is out of range (found {diameter}, allowed at most {LARGEST_DIAMETER_M}); the "
                f"unit is the metre, {diameter:g} mm are {diameter / 1000:g}"
            )
        return diameter


class _Environment(_Strict):
    gravity_m_per_s2: float = 9.80665
    air_density_kg_per_m3: Annotated[float, Field(ge=0)] = 1.2
    drag_coefficient: Annotated[float | None, Field(ge=0)] = None
    drag_coefficient_sigma: Annotated[float, Field(ge=0)] = DRAG_SIGMA


class _Measurement(_Strict):
    slow_position_m: Annotated[float, Field(ge=0)] = 0.0
    slow_rotation_rad: Annotated[float, Field(ge=0)] = 0.0
    scale_sigma: Annotated[float, Field(ge=0, lt=1)] = 0.0
    slow_memory_rad: Positive = MEMORY_RAD
    one_body_frame: bool = True


class _Description(_Strict):
    format: int
    name: Annotated[str, Field(min_length=1)]
    camera: _Camera
    spheres: Annotated[list[_Sphere], Field(min_length=2, max_length=2)]
    environment: _Environment = Field(default_factory=_Environment)
    measurement: _Measurement = Field(default_factory=_Measurement)

    @field_validator("spheres")
    @classmethod
    def _one_of_each_name(cls, spheres: list[_Sphere]) -> list[_Sphere]:
        if spheres[0].name == spheres[1].name:
            raise ValueError(f"both are named {spheres[0].name!r}; name them 'a' and 'b'")
        return spheres


def read_description(path: Path) -> tuple[str, Setup]:
    """Read campaign.toml.

    Returns
    -------
    The campaign's name and its set-up.

    Raises
    ------
    InputError
        Absent, empty, not TOML, or written in a newer format; or every key that is unknown,
        missing, or out of its range.
    """
    table = read_toml(path)
    if not table:
        raise InputError(path, "is empty; it must describe camera and spheres")
    found = table.get("format", FORMAT)
    if found != FORMAT:
        raise InputError(path, f"format {found!r}; this program reads format {FORMAT}")
    try:
        description = _Description.model_validate(table)
    except ValidationError as error:
        raise InputError(path, "; ".join(map(fault, error.errors()))) from error
    return description.name, _setup(description)


def _setup(description: _Description) -> Setup:
    camera = description.camera
    first, second = sorted(description.spheres, key=lambda sphere: sphere.name)
    return Setup(
        camera=CameraSetup(
            frame_rate_hz=camera.frame_rate_hz,
            height_px=camera.height_px,
            width_px=camera.width_px,
            front_view_rows=_pair(camera.front_view_rows) or (0, camera.height_px),
            top_view_rows=_pair(camera.top_view_rows),
            scale_px_per_m=camera.scale_px_per_m,
            front_origin_px=_pair(camera.front_origin_px),
            top_origin_px=_pair(camera.top_origin_px),
        ),
        spheres=(_sphere(first), _sphere(second)),
        gravity_m_per_s2=description.environment.gravity_m_per_s2,
        air_density_kg_per_m3=description.environment.air_density_kg_per_m3,
        slow=SlowErrors(
            position_m=description.measurement.slow_position_m,
            rotation_rad=description.measurement.slow_rotation_rad,
            scale=description.measurement.scale_sigma,
            one_body_frame=description.measurement.one_body_frame,
            memory_rad=description.measurement.slow_memory_rad,
        ),
        drag_coefficient=description.environment.drag_coefficient,
        drag_sigma=description.environment.drag_coefficient_sigma,
    )


def _sphere(sphere: _Sphere) -> SphereSetup:
    if sphere.plate or sphere.diameter_m is None:
        return SphereSetup(sphere.name, 0.0, sphere.density_kg_per_m3, 0.0, plate=True)
    return SphereSetup(
        sphere.name, sphere.diameter_m, sphere.density_kg_per_m3, sphere.inertia_factor
    )


def _pair(values: list[N] | None) -> tuple[N, N] | None:
    return None if values is None else (values[0], values[1])
