"""What the rig may be asked for, and when a reading counts as reached, fresh and safe."""

from __future__ import annotations

from pydantic import Field

from rigctl.config.model import Range, Seconds, StrictModel


class Limits(StrictModel):
    """Bounds of the settings and of the interlocks.

    An apparatus without pressure or without a slide says so with the range [0, 0]. `angle_deg`
    belongs to the release apparatus, whose tubes are turned by hand.
    """

    pressure_kpa: Range = Field(description="gauge pressure of each pusher, kPa")
    offset_mm: Range = Field(description="vertical offset of tube b below tube a, mm")
    delay_us: Range = Field(description="pusher b after pusher a, microseconds")
    angle_deg: Range | None = Field(
        default=None, description="tilt of each tube below the horizontal, degrees"
    )
    pressure_tolerance_kpa: float = Field(gt=0, description="reached within this, kPa")
    offset_tolerance_mm: float = Field(gt=0, description="reached within this, mm")
    settle_timeout_s: Seconds = Field(description="longest wait for pressure and offset, s")
    reading_max_age_s: Seconds = Field(description="an older reading counts as none, s")
    arm_lifetime_s: Seconds = Field(description="an arm token expires after this, s")
    cool_down_s: float = Field(ge=0, le=3600, description="rest between two shots, s")
    free_disk_mb: float = Field(gt=0, description="free space the store needs, 10^6 bytes")
    clock_step_s: float = Field(
        default=1.0, gt=0, description="largest jump of the wall clock against the monotonic, s"
    )
