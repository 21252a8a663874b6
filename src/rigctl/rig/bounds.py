"""Settings against the limits of this rig, before anything moves."""

from __future__ import annotations

from rigctl.config import Limits
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
        if value is None or not bounds[0] <= value <= bounds[1]:
            raise SettingsError(
                "is needed" if value is None else "lies outside the rig's limits",
                part=field,
                value=None if value is None else f"{value:g} {unit}",
                limit=f"{bounds[0]:g} to {bounds[1]:g} {unit}",
                todo="choose a value within the limits",
            )
