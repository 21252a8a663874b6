"""The form of a sweep file: which shots to fire, how often and in which order."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, ValidationError, model_validator

from analysis.files import toml_text
from rigctl.config.loading import checked, read_toml
from rigctl.config.model import StrictModel
from rigctl.errors import StoreError
from rigctl.plain_text import PLAIN
from rigctl.settings import ShotSettings

MOST_LEVELS = 1000

Spacing = Literal["linear", "logarithmic", "root"]


class Range(StrictModel):
    """Values from `first` to `last`, both included.

    `linear` spaces the values evenly, `logarithmic` their logarithms, `root` their square roots:
    pressures so spaced give speeds at even distances.
    """

    first: float = Field(description="first value")
    last: float = Field(description="last value")
    count: int = Field(ge=2, le=MOST_LEVELS, description="how many values")
    spacing: Spacing = Field(default="linear", description="what is spaced evenly")

    @model_validator(mode="after")
    def _can_be_spaced(self) -> Self:
        if self.first == self.last:
            raise ValueError(f"a range from {self.first:g} to {self.last:g} is empty")
        least = min(self.first, self.last)
        if self.spacing == "logarithmic" and least <= 0:
            raise ValueError(f"spacing 'logarithmic' needs values above 0, the least is {least:g}")
        if self.spacing == "root" and least < 0:
            raise ValueError(f"spacing 'root' needs values of at least 0, the least is {least:g}")
        return self

    def values(self) -> list[float]:
        """Return the values in order; the ends are exact."""
        shares = [k / (self.count - 1) for k in range(1, self.count - 1)]
        return [self.first, *(self._between(share) for share in shares), self.last]

    def _between(self, share: float) -> float:
        if self.spacing == "logarithmic":
            return float(self.first ** (1 - share) * self.last**share)
        if self.spacing == "root":
            return float((self.first**0.5 * (1 - share) + self.last**0.5 * share) ** 2)
        return self.first * (1 - share) + self.last * share


def _form(value: object) -> str:
    return "range" if isinstance(value, dict | Range) else "list"


def _each_once(values: list[float]) -> list[float]:
    for position, value in enumerate(values):
        if value in values[:position]:
            raise ValueError(f"{value:g} stands twice; use `repeat` to fire it more often")
    return values


Listed = Annotated[
    list[float], Field(min_length=1, max_length=MOST_LEVELS), AfterValidator(_each_once)
]
Levels = Annotated[
    Annotated[Listed, Tag("list")] | Annotated[Range, Tag("range")], Discriminator(_form)
]
"""A list of values, or a table that spaces them."""


def values_of(levels: Levels) -> list[float]:
    """Return the values of either form, in order."""
    return levels.values() if isinstance(levels, Range) else list(levels)


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
                message = (
                    f"grid: {first['loc'][0]} of {first['input']}: {first['msg'].lower()} for any "
                    "rig; this one's own limits are in [limits] of its configuration"
                )
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


def sweep_text(sweep: Sweep) -> str:
    """Return TOML that reads back as the same sweep; what is at its default is left out."""
    return toml_text(sweep.model_dump(mode="json", exclude_defaults=True))


def write_sweep(path: Path, sweep: Sweep) -> None:
    """Write a sweep file; one of that name is replaced.

    Raises
    ------
    StoreError
        It cannot be written.
    """
    try:
        path.write_text(sweep_text(sweep), encoding="utf-8")
    except OSError as error:
        raise StoreError(
            f"cannot be written: {error.strerror}",
            part=str(path),
            todo="name a file in a folder that exists",
        ) from error
