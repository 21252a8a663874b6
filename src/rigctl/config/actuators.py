"""Sections of the devices that move, pressurise, fire and cut: one model for each driver."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigctl.config.model import Port, Seconds, StrictModel

PowerCut = Literal["fires", "holds"]
"""What the spheres do when the actuators lose their power."""

Channel = Annotated[int, Field(ge=1, le=8)]


class TriggerBox(StrictModel):
    """Microcontroller that fires both pushers from one command.

    Pushers work against a spring: energised they fire, and a power cut holds.
    """

    driver: Literal["trigger-box"]
    port: Port
    pulse_us: int = Field(ge=100, le=100_000, description="width of each pulse, microseconds")
    answer_timeout_s: Seconds
    power_cut: Literal["holds"] = "holds"
    heartbeat: bool = Field(
        default=True, description="the box makes itself safe when the daemon dies or hangs"
    )


class SolenoidPair(StrictModel):
    """Two channels of an LCUS board, one solenoid each (release apparatus, thesis 3.2).

    What the energised solenoid does and what a power cut does must both be stated, and must
    agree: a solenoid that holds while energised lets go when the power is cut.
    """

    driver: Literal["solenoid-pair"]
    port: Port
    channel_a: Channel
    channel_b: Channel
    energised: Literal["hold", "release"]
    power_cut: PowerCut

    @model_validator(mode="after")
    def _agrees_with_itself(self) -> Self:
        if self.channel_a == self.channel_b:
            raise ValueError(f"channel_a and channel_b are both {self.channel_a}")
        expected = "fires" if self.energised == "hold" else "holds"
        if self.power_cut != expected:
            raise ValueError(
                f"energised = {self.energised!r} means power_cut = {expected!r}, "
                f"not {self.power_cut!r}"
            )
        return self


class Magnet(StrictModel):
    """One channel of an LCUS board with the magnet that holds a sphere (thesis, chapter 6).

    It holds while energised: switched off it lets go, and so does a power cut.
    """

    driver: Literal["magnet"]
    port: Port
    channel: Channel
    power_cut: Literal["fires"]


TriggerSection = Annotated[TriggerBox | SolenoidPair | Magnet, Field(discriminator="driver")]


class Alicat(StrictModel):
    """Two Alicat pressure controllers on one bus, addressed by letter."""

    driver: Literal["alicat"]
    port: Port
    unit_a: str = Field(pattern="^[A-Z]$")
    unit_b: str = Field(pattern="^[A-Z]$")
    answer_timeout_s: Seconds

    @model_validator(mode="after")
    def _two_units(self) -> Self:
        if self.unit_a == self.unit_b:
            raise ValueError(f"unit_a and unit_b are both {self.unit_a!r}")
        return self


class Zaber(StrictModel):
    """Zaber stage that carries tube b; `microsteps_per_mm` as its data sheet states."""

    driver: Literal["zaber"]
    port: Port
    microsteps_per_mm: float = Field(gt=0)
    answer_timeout_s: Seconds


class Lcus(StrictModel):
    """One channel of an LCUS relay board as the cut-off: the emergency stop's own line."""

    driver: Literal["lcus"]
    port: Port
    channel: Channel
    dead_man: bool = Field(
        default=True, description="a process of its own cuts when the daemon dies or hangs"
    )
