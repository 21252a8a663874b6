"""What is known before a shot: camera, spheres and surroundings (formats.md, campaign.toml)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CameraSetup:
    """The camera and its two views.

    Attributes
    ----------
    frame_rate_hz
        Frames a second; used where frames carry no times of their own.
    height_px, width_px
        Size of a frame.
    front_view_rows, top_view_rows
        Half-open ranges of rows; no top view: None, and Z is taken as constant.
    scale_px_per_m
        None: taken from the spheres' diameter in the images.
    front_origin_px, top_origin_px
        (row, column) where X = Y = Z = 0 appears; None: the centre of the view.
    exposure_s
        Time the shutter is open, centred on a frame's time.
    """

    frame_rate_hz: float
    height_px: int = 192
    width_px: int = 240
    front_view_rows: tuple[int, int] = (0, 192)
    top_view_rows: tuple[int, int] | None = None
    scale_px_per_m: float | None = None
    front_origin_px: tuple[float, float] | None = None
    top_origin_px: tuple[float, float] | None = None
    exposure_s: float = 0.0


@dataclass(frozen=True, slots=True)
class SphereSetup:
    """One sphere: diameter in m, density in kg/m^3, inertia factor I / (m r^2).

    A plate stands still, has no diameter, and comes only as sphere b.
    """

    name: str
    diameter_m: float
    density_kg_per_m3: float = 1150.0
    inertia_factor: float = 0.4
    plate: bool = False


@dataclass(frozen=True, slots=True)
class Setup:
    """Everything a shot's analysis needs beside its frames.

    `gravity_m_per_s2` acts along +X (down). Poses that were measured elsewhere may come with the
    size of the errors that the frames of one flight share, in place and in orientation, and with
    body axes of their own in each shot.
    """

    camera: CameraSetup
    spheres: tuple[SphereSetup, SphereSetup]
    gravity_m_per_s2: float = 9.80665
    air_density_kg_per_m3: float = 1.2
    slow_position_m: float = 0.0
    slow_rotation_rad: float = 0.0
    one_body_frame: bool = True
