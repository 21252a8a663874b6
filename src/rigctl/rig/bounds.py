"""Settings against the limits and the spheres of this rig, before anything moves."""

from __future__ import annotations

from rigctl.config import Configuration, Limits
from rigctl.errors import SettingsError
from rigctl.settings import ShotSettings

_FIELDS = (
    ("pressure_a_kpa", "pressure_kpa", "kPa"),
    ("pressure_b_kpa", "pressure_kpa", "kPa"),
    ("offset_mm", "offset_mm", "mm"),
    ("delay_us", "delay_us", "us"),
    ("angle_a_deg", "angle_deg", "degrees"),
    ("angle_b_deg", "angle_deg", "degrees"),
)

OUTSIDE = "lies outside the rig's limits"


def require_within(settings: ShotSettings, limits: Limits) -> None:
    """Check every setting against the rig's limits.

    Raises
    ------
    SettingsError
        A setting lies outside, or an angle is missing or given for an apparatus without tilt.
    """
    for field, limit, unit in _FIELDS:
        value: float | None = getattr(settings, field)
        bounds: tuple[float, float] | None = getattr(limits, limit)
        if bounds is None and value is None:
            continue
        if bounds is None:
            raise SettingsError(
                "this apparatus has no such setting",
                part=field,
                value=f"{value:g} {unit}",
                todo="leave it out",
            )
        if value is None:
            raise SettingsError(
                "is needed",
                part=field,
                limit=allowed(field, limits),
                todo="choose a value within the limits",
            )
        require_value(field, value, limits)


def require_value(field: str, value: float, limits: Limits) -> None:
    """Check one value of a setting against the rig's limits; any is right where there are none.

    Raises
    ------
    SettingsError
        It lies outside.
    """
    for name, limit, unit in _FIELDS:
        bounds: tuple[float, float] | None = getattr(limits, limit)
        if name == field and bounds is not None and not bounds[0] <= value <= bounds[1]:
            raise SettingsError(
                OUTSIDE,
                part=field,
                value=f"{value:g} {unit}",
                limit=allowed(field, limits),
                todo="choose a value within the limits",
            )


def allowed(field: str, limits: Limits) -> str | None:
    """Return a setting's limits on this rig as text, with the unit; None where there are none."""
    for name, limit, unit in _FIELDS:
        bounds: tuple[float, float] | None = getattr(limits, limit)
        if name == field and bounds is not None:
            return f"{bounds[0]:g} to {bounds[1]:g} {unit}"
    return None


def misses(settings: ShotSettings, configuration: Configuration) -> tuple[str, ...]:
    """Warn where the tubes stand further apart than the spheres reach; empty otherwise.

    What flies level at one height touches what flies level at another only if the heights differ
    by less than the sum of the radii. Nothing is refused: somebody may want just that.
    """
    a, b = configuration.spheres
    reach_mm = 500.0 * (a.diameter_m + b.diameter_m)
    if b.plate or abs(settings.offset_mm) < reach_mm:
        return ()
    return (
        f"the spheres cannot meet in level flight: offset_mm is {settings.offset_mm:g} mm, the sum "
        f"of their radii {reach_mm:.4g} mm",
    )
