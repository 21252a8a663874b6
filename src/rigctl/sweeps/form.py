"""The form of a sweep file: which shots to fire, how often and in which order."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, ValidationError, model_validator

from rigctl.config.loading import checked, read_toml
from rigctl.config.model import StrictModel
from rigctl.plain_text import PLAIN
from rigctl.settings import ShotSettings
from rigctl.sweeps.levels import Levels, values_of

MOST_SHOTS = 10_000

Repeat = Annotated[int, Field(ge=1, le=1000)]


class Grid(StrictModel):
    """Every combination of some values, the last-named setting changing fastest."""

    pressure_a_kpa: Levels = Field(description="pusher a, gauge pressure in kPa")
    pressure_b_kpa: Levels | None = Field(
        default=None, description="pusher b likewise; without it as pusher a in every shot"
    )
    offset_mm: Levels = Field(description="vertical offset of tube b below tube a in mm")
    delay_us: Levels = Field(
        default=[0.0], description="pusher b fires this much later than pusher a, in microseconds"
    )

    def size(self) -> int:
        """Return the number of combinations."""
        own = 1 if self.pressure_b_kpa is None else len(values_of(self.pressure_b_kpa))
        others = (self.pressure_a_kpa, self.offset_mm, self.delay_us)
        size = own
        for levels in others:
            size *= len(values_of(levels))
        return size

    def settings(self) -> list[ShotSettings]:
        """Return all combinations.

        Raises
        ------
        ValidationError
            A value is beyond what any rig has.
        """
        listed = None if self.pressure_b_kpa is None else values_of(self.pressure_b_kpa)
        return [
            ShotSettings(pressure_a_kpa=a, pressure_b_kpa=b, offset_mm=offset, delay_us=delay)
            for a in values_of(self.pressure_a_kpa)
            for b in (listed or [a])
            for offset in values_of(self.offset_mm)
            for delay in values_of(self.delay_us)
        ]


class RepeatedShot(ShotSettings):
    """One setting, fired so many times."""

    repeat: Repeat = Field(default=1, description="how often it is fired")

    def settings(self) -> ShotSettings:
        """Return the setting by itself."""
        return ShotSettings(**self.model_dump(exclude={"repeat"}))


class UntilKnown(StrictModel):
    """End the sweep before its last shot once a coefficient is known well enough."""

    coefficient: Literal["e", "beta"] = Field(description="coefficient of each shot's result")
    sigma: float = Field(
        gt=0,
        le=1,
        description="standard error of its mean over the sweep's shots to be reached, by their own "
        "errors: what all shots share stays",
    )
    adaptive: bool = Field(
        default=False, description="fire next where the shots so far have told most about it"
    )


class Sweep(StrictModel):
    """A sweep: a grid, shots listed one by one, or both."""

    campaign: str | None = Field(
        default=None,
        min_length=1,
        max_length=64,
        pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$",
        description="campaign that the shots belong to",
    )
    note: str = Field(
        default="", max_length=1000, pattern=PLAIN, description="what the sweep is for"
    )
    repeat: Repeat = Field(default=1, description="how often all is fired, grid and list alike")
    shuffle: bool = Field(
        default=True, description="fire in a drawn order, so that a drift is no effect of a setting"
    )
    seed: int = Field(default=0, ge=0, lt=2**63, description="draws the order")
    settle_s: float = Field(
        default=0.0, ge=0, le=3600, description="wait between settings reached and fire, s"
    )
    pause_s: float = Field(
        default=0.0, ge=0, le=3600, description="rest after each shot beyond the rig's own, s"
    )
    most_failed: int = Field(
        default=3, ge=1, le=1000, description="so many failed shots in a row pause the sweep"
    )
    until: UntilKnown | None = Field(default=None, description="end early once this is known")
    grid: Grid | None = Field(default=None, description="every combination of some values")
    shots: list[RepeatedShot] = Field(
        default=[], max_length=MOST_SHOTS, description="shots listed one by one"
    )

    @model_validator(mode="after")
    def _holds_shots(self) -> Self:
        count = self.count()
        if not 1 <= count <= MOST_SHOTS:
            raise ValueError(f"a sweep holds 1 to {MOST_SHOTS} shots, this one {count}")
        if self.grid is not None:
            try:
                self.grid.settings()
            except ValidationError as error:
                first = error.errors()[0]
                message = f"grid: {first['loc'][0]} of {first['input']}: {first['msg'].lower()}"
                raise ValueError(message) from error
        return self

    def count(self) -> int:
        """Return the number of shots."""
        listed = sum(shot.repeat for shot in self.shots)
        return self.repeat * (listed + (self.grid.size() if self.grid else 0))

    def steps(self) -> list[ShotSettings]:
        """Return the settings of every shot in the order of firing.

        The grid comes before the list, and all of it again for each repeat; then the whole is
        shuffled. The same seed gives the same order.
        """
        once = self.grid.settings() if self.grid else []
        once += [shot.settings() for shot in self.shots for _ in range(shot.repeat)]
        every = once * self.repeat
        if self.shuffle:
            random.Random(self.seed).shuffle(every)
        return every


def read_sweep(path: Path) -> Sweep:
    """Read and check a sweep file.

    Raises
    ------
    ConfigurationError
        The file cannot be read, is not TOML, or holds a field that cannot be. The error names
        the file, the field, the value and the limit.
    """
    return checked(Sweep, read_toml(path), str(path))
