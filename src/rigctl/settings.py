"""What an operator chooses for one shot."""

from __future__ import annotations

from pydantic import Field

from rigctl.config.model import StrictModel


class ShotSettings(StrictModel):
    """Settings of one shot, as REST and the sweep hand them in.

    Strict: a string or a boolean where a number belongs is refused, and so is an unknown field.
    The bounds here are those of physics; a rig's own limits are narrower and stand in its
    configuration.
    """

    pressure_a_kpa: float = Field(ge=0, le=1000, description="pusher a, gauge pressure in kPa")
    pressure_b_kpa: float = Field(ge=0, le=1000, description="pusher b, gauge pressure in kPa")
    offset_mm: float = Field(
        ge=-100, le=100, description="vertical offset of tube b below tube a in mm"
    )
    delay_us: float = Field(
        default=0.0,
        ge=-100_000,
        le=100_000,
        description="pusher b fires this much later than pusher a, in microseconds",
    )
    angle_a_deg: float | None = Field(
        default=None,
        ge=0,
        le=90,
        description="tilt of tube a below the horizontal in degrees; release apparatus only",
    )
    angle_b_deg: float | None = Field(
        default=None,
        ge=0,
        le=90,
        description="tilt of tube b below the horizontal in degrees; release apparatus only",
    )
