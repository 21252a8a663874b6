"""Sections of the camera: what starts it, what confirms it, where its frames come from."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigctl.config.actuators import Channel
from rigctl.config.model import Port, Seconds, StrictModel

EKTAPRO_ROWS = 192
EKTAPRO_COLUMNS = 240
PixelFormatName = Literal["GREY", "YUYV", "UYVY", "Y10", "Y12", "Y16"]
"""Uncompressed formats of video devices, by their names in Video4Linux2."""


class HidRelay(StrictModel):
    """USB relay 16c0:05df whose contact starts the recorder."""

    driver: Literal["hid-relay"]
    channel: Channel


class SerialLine(StrictModel):
    """RTS line of a port as the contact that starts the recorder."""

    driver: Literal["serial-line"]
    port: Port


class EktaproLink(StrictModel):
    """Recorder link of the wire-protocol reference; not Kodak's protocol."""

    driver: Literal["ektapro-link"]
    port: Port
    answer_timeout_s: Seconds


class FilesSource(StrictModel):
    """Folder into which a digitiser puts each stack."""

    driver: Literal["files"]
    folder: str = Field(min_length=1)


Edge = Annotated[int, Field(ge=0, le=4096)]


class V4l2Source(StrictModel):
    """Frame grabber that digitises the recorder's playback.

    One whose frames have another size than the recorder's pictures states it, and which part of
    them holds the picture; it is then brought to the recorder's size.
    """

    driver: Literal["v4l2"]
    device: str = Field(min_length=1)
    input: int = Field(default=0, ge=0)
    pixel_format: PixelFormatName = Field(default="GREY", description="asked of the driver")
    frame_rows: int | None = Field(default=None, ge=8, le=4096, description="of a grabber's frame")
    frame_columns: int | None = Field(
        default=None, ge=8, le=4096, description="of a grabber's frame"
    )
    crop: tuple[Edge, Edge, Edge, Edge] | None = Field(
        default=None, description="first row and column, rows and columns; else the whole frame"
    )
    playback: Literal["step", "run"] = Field(
        default="step", description="step from picture to picture, or digitise while the tape plays"
    )
    scan: Literal["progressive", "top-first", "bottom-first"] = Field(
        default="progressive", description="of the grabber's frames: at once, or two fields"
    )

    @model_validator(mode="after")
    def _crops_within_its_frame(self) -> Self:
        rows, columns = self.frame_rows, self.frame_columns
        if rows is None or columns is None:
            if (rows, columns, self.crop) != (None, None, None):
                raise ValueError("frame_rows and frame_columns are given together, crop with them")
            return self
        top, left, high, wide = self.crop or (0, 0, rows, columns)
        if high < 8 or wide < 8 or top + high > rows or left + wide > columns:
            raise ValueError(f"crop {self.crop} does not lie in a frame of {rows} x {columns}")
        return self


RemoteTriggerSection = Annotated[HidRelay | SerialLine, Field(discriminator="driver")]
SourceSection = Annotated[FilesSource | V4l2Source, Field(discriminator="driver")]


class _Recording(StrictModel):
    rows: int = Field(ge=8, le=4096, description="rows of one picture")
    columns: int = Field(ge=8, le=4096, description="columns of one picture")
    start_timeout_s: Seconds = Field(description="longest wait for a confirmed recording, s")
    collect_timeout_s: Seconds = Field(description="longest wait for the frames, s")
    frames_before_mark: int = Field(ge=0, le=10_000)
    frames_after_mark: int = Field(ge=1, le=10_000)
    exposure_us: float | None = Field(
        default=None,
        ge=0,
        le=1e6,
        description="time the shutter is open, us; not known: up to that between two pictures",
    )

    @property
    def frames_bytes(self) -> int:
        """Bytes of the frames of one shot, 8 bits a pixel."""
        return self.rows * self.columns * (self.frames_before_mark + self.frames_after_mark)


class EktaproCamera(_Recording):
    """Kodak EktaPro 1000, a tape recorder: it records only after it was told (thesis, app. A).

    `rows` are those of one picture: 192 divided by `pictures_per_frame`.
    """

    kind: Literal["ektapro"]
    frame_rate_hz: Literal[30, 60, 125, 250, 500, 1000]
    pictures_per_frame: Literal[1, 2, 3, 4, 6]
    when_full: Literal["ask", "erase"] = Field(
        default="ask", description="a tape without room for a shot: refuse to arm, or erase it"
    )
    remote_trigger: RemoteTriggerSection | None = None
    recorder: EktaproLink
    source: SourceSection

    @model_validator(mode="after")
    def _has_the_format(self) -> Self:
        rows = EKTAPRO_ROWS // self.pictures_per_frame
        if (self.rows, self.columns) != (rows, EKTAPRO_COLUMNS):
            raise ValueError(
                f"{self.pictures_per_frame} pictures per frame have {rows} rows and "
                f"{EKTAPRO_COLUMNS} columns, not {self.rows} and {self.columns}"
            )
        return self

    @property
    def picture_rate_hz(self) -> float:
        """Pictures recorded per second: full frames times pictures per frame."""
        return float(self.frame_rate_hz * self.pictures_per_frame)


class FreeRateCamera(_Recording):
    """A camera of today, whose rate is a plain number."""

    frame_rate_hz: float = Field(gt=0, le=100_000)

    @property
    def picture_rate_hz(self) -> float:
        """Pictures recorded per second."""
        return self.frame_rate_hz


class V4l2Camera(FreeRateCamera):
    """Camera behind the kernel's Video4Linux2 interface, recording into memory by itself."""

    kind: Literal["v4l2"]
    device: str = Field(min_length=1)
    input: int = Field(default=0, ge=0)
    pixel_format: PixelFormatName = Field(default="GREY", description="asked of the driver")
    buffers: int = Field(default=32, ge=2, le=64)


class ChronosCamera(FreeRateCamera):
    """Chronos of Krontech: records into its own memory, spoken to over HTTP."""

    kind: Literal["chronos"]
    url: str = Field(pattern="^[a-z]+:.+$", description="address of the camera")
    storage: str = Field(
        default="sda1", pattern="^[A-Za-z0-9]+$", description="its storage to save frames on"
    )
    answer_timeout_s: Seconds = Field(default=2.0, description="longest wait for an answer, s")


class GenicamCamera(FreeRateCamera):
    """Camera with GenICam (GigE Vision, USB3 Vision), through the library Aravis."""

    kind: Literal["genicam"]
    camera_id: str = Field(min_length=1, description="maker-model-serial, as Aravis lists it")
    pixel_format: Literal["Mono8"] = "Mono8"
    buffers: int = Field(default=16, ge=2, le=256)


class OwnCamera(FreeRateCamera):
    """Camera of a lab's own: a function that returns a `VideoSource` or a `MemoryCamera`."""

    kind: Literal["own"]
    factory: str = Field(pattern=r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$", description="module:function")
    options: dict[str, str | int | float | bool] = Field(
        default={}, description="handed to the function"
    )


class FilmCamera(FreeRateCamera):
    """Camera that people work, as a telephone: they say that it records and bring its film."""

    kind: Literal["film"]
    corner: tuple[Edge, Edge] = Field(
        default=(0, 0), description="first row and column of the part of its pictures that is kept"
    )


CameraSection = Annotated[
    EktaproCamera | V4l2Camera | ChronosCamera | GenicamCamera | OwnCamera | FilmCamera,
    Field(discriminator="kind"),
]
