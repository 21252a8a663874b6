"""campaign.toml: camera, spheres and surroundings of a campaign."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from analysis.errors import InputError
from analysis.setup import CameraSetup, Setup, SphereSetup

FORMAT = 1

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


class _Sphere(_Strict):
    name: Literal["a", "b"]
    diameter_m: Positive | None = None
    density_kg_per_m3: Positive = 1150.0
    inertia_factor: Positive = 0.4
    plate: bool = False


class _Environment(_Strict):
    gravity_m_per_s2: float = 9.80665
    air_density_kg_per_m3: Annotated[float, Field(ge=0)] = 1.2


class _Description(_Strict):
    format: int
    name: Annotated[str, Field(min_length=1)]
    camera: _Camera
    spheres: Annotated[list[_Sphere], Field(min_length=2, max_length=2)]
    environment: _Environment = Field(default_factory=_Environment)


def read_description(path: Path) -> tuple[str, Setup]:
    """Read campaign.toml.

    Returns
    -------
    The campaign's name and its set-up.

    Raises
    ------
    InputError
        Absent, not TOML, an unknown or missing key, a value out of its range, or written in a
        newer format; with the key.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError(path, "no such file") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(path, f"not TOML: {error}") from error
    found = table.get("format")
    if found != FORMAT:
        raise InputError(path, f"format {found!r}; this program reads format {FORMAT}")
    try:
        description = _Description.model_validate(table)
    except ValidationError as error:
        raise InputError(path, _first_fault(error)) from error
    return description.name, _setup(path, description)


def _first_fault(error: ValidationError) -> str:
    fault = error.errors()[0]
    key = ".".join(str(part) for part in fault["loc"])
    value: Any = fault["input"]
    shown = "" if isinstance(value, dict) else f" (found {value!r})"
    return f"{key}: {fault['msg']}{shown}"


def _setup(path: Path, description: _Description) -> Setup:
    camera = description.camera
    first, second = sorted(description.spheres, key=lambda sphere: sphere.name)
    if first.name == second.name:
        raise InputError(path, f"spheres: both are named {first.name!r}; name them 'a' and 'b'")
    return Setup(
        camera=CameraSetup(
            frame_rate_hz=camera.frame_rate_hz,
            height_px=camera.height_px,
            width_px=camera.width_px,
            front_view_rows=_rows(path, "front_view_rows", camera.front_view_rows, camera)
            or (0, camera.height_px),
            top_view_rows=_rows(path, "top_view_rows", camera.top_view_rows, camera),
            scale_px_per_m=camera.scale_px_per_m,
            front_origin_px=_pixel(camera.front_origin_px),
            top_origin_px=_pixel(camera.top_origin_px),
        ),
        spheres=(_sphere(path, first), _sphere(path, second)),
        gravity_m_per_s2=description.environment.gravity_m_per_s2,
        air_density_kg_per_m3=description.environment.air_density_kg_per_m3,
    )


def _sphere(path: Path, sphere: _Sphere) -> SphereSetup:
    if sphere.plate:
        return SphereSetup(sphere.name, 0.0, sphere.density_kg_per_m3, 0.0, plate=True)
    if sphere.diameter_m is None:
        raise InputError(path, f"spheres: sphere {sphere.name!r} has no diameter_m")
    return SphereSetup(
        sphere.name, sphere.diameter_m, sphere.density_kg_per_m3, sphere.inertia_factor
    )


def _rows(path: Path, key: str, rows: list[int] | None, camera: _Camera) -> tuple[int, int] | None:
    if rows is None:
        return None
    if not 0 <= rows[0] < rows[1] <= camera.height_px:
        raise InputError(
            path,
            f"camera.{key}: {rows} is not a half-open range of rows within 0 to {camera.height_px}",
        )
    return rows[0], rows[1]


def _pixel(pixel: list[float] | None) -> tuple[float, float] | None:
    return None if pixel is None else (pixel[0], pixel[1])
