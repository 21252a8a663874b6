"""The whole configuration of one rig."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from typing import Literal, Self

from pydantic import ConfigDict, Field, ValidationError, model_validator

from analysis.exchange.faults import fault
from analysis.files import FileLimits
from analysis.material import StatedMaterial
from analysis.setup import Environment, Setup, SphereSetup, setup_of
from rigctl.config.actuators import Alicat, Lcus, SolenoidPair, TriggerSection, Zaber
from rigctl.config.camera import (
    CameraSection,
    ChronosCamera,
    EktaproCamera,
    FilesSource,
    SerialLine,
    V4l2Camera,
)
from rigctl.config.limits import Limits
from rigctl.config.model import SIMULATED, StrictModel
from rigctl.config.scene import Optics


class Simulation(StrictModel):
    """What stands in for the laboratory; absent on a real rig.

    Every further key is an option of the factory, which checks it.
    """

    model_config = ConfigDict(extra="allow")

    factory: str = Field(pattern=r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$", description="module:function")

    @property
    def options(self) -> dict[str, object]:
        """Everything in the table but the factory's name."""
        return dict(self.model_extra or {})


class StoreSection(StrictModel):
    """Where shots are kept; a relative folder counts from the working directory."""

    folder: str = Field(min_length=1)
    database: str | None = Field(
        default=None,
        pattern=r"^postgresql(\+psycopg)?://",
        description="catalogue on a server; without it a SQLite file in the folder",
    )


class ServiceSection(StrictModel):
    """Where the service listens."""

    host: str = Field(min_length=1)
    port: int = Field(ge=0, le=65535, description="0 takes any free port")
    stop_port: int | None = Field(
        default=None,
        ge=0,
        le=65535,
        description="port of the emergency stop alone; without it 1000 above, or any free one",
    )
    names: tuple[str, ...] = Field(
        default=(), description="names of this service, beside its address, behind a proxy or DNS"
    )
    tls_certificate: str | None = Field(
        default=None, min_length=1, description="PEM file with certificate and chain"
    )
    tls_key: str | None = Field(
        default=None, min_length=1, description="PEM file with the certificate's private key"
    )
    proxy: str | None = Field(
        default=None,
        min_length=1,
        description="address of the reverse proxy that encrypts; nobody else is answered",
    )

    @model_validator(mode="after")
    def _has_certificate_and_key_or_neither(self) -> Self:
        if (self.tls_certificate is None) != (self.tls_key is None):
            raise ValueError("tls_certificate and tls_key are given together, or neither")
        return self

    @property
    def encrypts(self) -> bool:
        """Whether the service itself encrypts its connections."""
        return self.tls_certificate is not None


class AnalysisSection(StrictModel):
    """How stored shots are analysed."""

    workers: int = Field(ge=1, le=64)
    method: Literal["thesis", "photometric"]
    timeout_s: float = Field(default=300.0, gt=0, le=86_400, description="longest analysis, s")
    effects: str | None = Field(
        default=None, min_length=1, description="folder of effects of your own, ranked with all"
    )


_FIRED_BY = {"pusher": "trigger-box", "release": "solenoid-pair", "drop": "magnet"}
"""Driver of each apparatus's trigger."""


class Configuration(StrictModel):
    """One rig: its devices, limits, camera, scene, store and service."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$")
    apparatus: Literal["pusher", "release", "drop"]
    simulation: Simulation | None = None
    limits: Limits
    trigger: TriggerSection
    regulator: Alicat | None = None
    slide: Zaber | None = None
    cut_off: Lcus
    camera: CameraSection
    store: StoreSection
    service: ServiceSection
    analysis: AnalysisSection
    files: FileLimits | None = None
    optics: Optics
    spheres: tuple[SphereSetup, SphereSetup]
    environment: Environment
    material: StatedMaterial | None = None

    @property
    def setup(self) -> Setup:
        """What the analysis must know of camera, spheres and surroundings."""
        exposure_us = self.camera.exposure_us
        camera = {
            "frame_rate_hz": self.camera.picture_rate_hz,
            "height_px": self.camera.rows,
            "width_px": self.camera.columns,
            "exposure_s": None if exposure_us is None else exposure_us * 1e-6,
            **self.optics.model_dump(),
        }
        own = {"spheres", "environment", "material"}
        scene = self.model_dump(mode="json", include=own, exclude_none=True)
        return setup_of({"camera": camera, **scene})

    @property
    def digest(self) -> str:
        """SHA-256 of the configuration as canonical JSON, for manifests."""
        text = json.dumps(self.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()

    @property
    def scene(self) -> dict[str, object]:
        """What a simulated world takes over, as JSON.

        Apparatus, spheres, material, environment, optics, rows and exposure of a picture, and what
        energised solenoids do.
        """
        own = {"apparatus", "spheres", "environment", "optics", "material"}
        document = self.model_dump(mode="json", include=own)
        document |= {"exposure_us": self.camera.exposure_us, "rows": self.camera.rows}
        if isinstance(self.trigger, SolenoidPair):
            document["energised"] = self.trigger.energised
        return document

    @model_validator(mode="after")
    def _has_its_apparatus(self) -> Self:
        pusher, release = self.apparatus == "pusher", self.apparatus == "release"
        if (self.regulator is not None, self.slide is not None) != (pusher, pusher):
            word = "needs" if pusher else "has no"
            raise ValueError(f"the {self.apparatus} apparatus {word} regulator and slide")
        if self.trigger.driver != _FIRED_BY[self.apparatus]:
            raise ValueError(f"{self.trigger.driver} cannot fire the {self.apparatus} apparatus")
        if release != (self.limits.angle_deg is not None):
            word = "needs" if release else "has no"
            raise ValueError(f"the {self.apparatus} apparatus {word} limits.angle_deg")
        if self.apparatus == "drop" and not self.spheres[1].plate:
            raise ValueError("the drop apparatus needs a plate as sphere b, what sphere a falls on")
        return self

    @model_validator(mode="after")
    def _ports_are_all_real_or_all_simulated(self) -> Self:
        simulated = self.simulation is not None
        for field, port in self._acting_ports():
            if port.startswith(SIMULATED) != simulated:
                rule = "must" if simulated else "must not"
                raise ValueError(f"{field} = {port!r} {rule} begin with {SIMULATED!r}")
        for field, port in self._camera_ports():
            if port.startswith(SIMULATED) and not simulated:
                raise ValueError(f"{field} = {port!r} needs the table [simulation]")
        return self

    @model_validator(mode="after")
    def _ports_are_their_own(self) -> Self:
        seen: dict[str, str] = {}
        for field, port in (*self._acting_ports(), *self._camera_ports()):
            if port in seen:
                raise ValueError(f"{field} and {seen[port]} share the port {port!r}")
            seen[port] = field
        return self

    @model_validator(mode="after")
    def _has_a_setup(self) -> Self:
        try:
            self.setup  # noqa: B018 - it is checked as it is made
        except ValidationError as error:
            # What of the camera is not its own section's stands under optics.
            raise ValueError(fault(error.errors()[0]).replace("camera.", "optics.", 1)) from error
        return self

    def _acting_ports(self) -> Iterator[tuple[str, str]]:
        yield "trigger.port", self.trigger.port
        yield "cut_off.port", self.cut_off.port
        if self.regulator is not None:
            yield "regulator.port", self.regulator.port
        if self.slide is not None:
            yield "slide.port", self.slide.port

    def _camera_ports(self) -> Iterator[tuple[str, str]]:
        if isinstance(self.camera, V4l2Camera):
            yield "camera.device", self.camera.device
        if isinstance(self.camera, ChronosCamera):
            yield "camera.url", self.camera.url
        if not isinstance(self.camera, EktaproCamera):
            return
        yield "camera.recorder.port", self.camera.recorder.port
        if isinstance(self.camera.remote_trigger, SerialLine):
            yield "camera.remote_trigger.port", self.camera.remote_trigger.port
        source = self.camera.source
        if isinstance(source, FilesSource):
            yield "camera.source.folder", source.folder
        else:
            yield "camera.source.device", source.device
