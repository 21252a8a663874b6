"""An apparatus that fires nothing: a stage that is moved, or a disk that turns, before a camera."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, Self

from pydantic import Field, model_validator

from rigctl.config.actuators import Zaber
from rigctl.config.camera import CameraSection
from rigctl.config.configuration import Simulation
from rigctl.config.loading import checked, read_toml
from rigctl.config.model import SIMULATED, Seconds, StrictModel


class StageSection(StrictModel):
    """Steps of a sphere on the slide (thesis, 4.2)."""

    steps: int = Field(ge=2, le=100, description="steps from the start")
    step_mm: float = Field(gt=0, le=100, description="way of each step, mm")
    start_mm: float = Field(ge=0, le=1000, description="first place, mm from the home sensor")
    tolerance_mm: float = Field(gt=0, le=1, description="reached within this, mm")
    settle_timeout_s: Seconds = Field(description="longest wait for a place, s")
    scale_px_per_m: float = Field(gt=0, le=1e9, description="of the image")
    direction: Literal["x", "y", "x-y"] = Field(
        default="x", description="along the columns, the rows, or both alike"
    )

    @property
    def step_px(self) -> tuple[float, float]:
        """Way of each step in the image, (row, column) in pixels."""
        way = 1e-3 * self.step_mm * self.scale_px_per_m
        return (way * ("y" in self.direction), way * ("x" in self.direction))


class DiskSection(StrictModel):
    """A disk on a motor's shaft (thesis, chapter 6)."""

    rate_rpm: float = Field(gt=0, le=1e6, description="turns a minute, as its meter shows")


class Bench(StrictModel):
    """Camera, and slide or disk before it."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$")
    apparatus: Literal["stage", "disk"]
    simulation: Simulation | None = None
    slide: Zaber | None = None
    stage: StageSection | None = None
    disk: DiskSection | None = None
    camera: CameraSection

    @property
    def scene(self) -> dict[str, object]:
        """What a simulated world takes over, as JSON."""
        own = {"apparatus", "stage", "disk"}
        document = self.model_dump(mode="json", include=own, exclude_none=True)
        return document | {"exposure_us": self.camera.exposure_us}

    @model_validator(mode="after")
    def _has_its_parts(self) -> Self:
        stage = self.apparatus == "stage"
        if (self.slide is None, self.stage is None, self.disk is None) != (
            not stage,
            not stage,
            stage,
        ):
            wanted = (
                "slide and stage, and no disk" if stage else "disk, and neither slide nor stage"
            )
            raise ValueError(f"the {self.apparatus} apparatus has the sections {wanted}")
        return self

    @model_validator(mode="after")
    def _moves_what_is_simulated_or_what_is_real(self) -> Self:
        simulated = self.simulation is not None
        if self.slide is not None and self.slide.port.startswith(SIMULATED) != simulated:
            rule = "must" if simulated else "must not"
            raise ValueError(f"slide.port = {self.slide.port!r} {rule} begin with {SIMULATED!r}")
        return self


def load_bench(path: Path) -> Bench:
    """Read and check the file of a stage or a disk.

    Raises
    ------
    ConfigurationError
        As `load`.
    """
    return checked(Bench, read_toml(path), str(path))
