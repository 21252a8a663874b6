"""What is known before a shot: camera, spheres and surroundings (formats.md, campaign.toml)."""

from __future__ import annotations

from dataclasses import dataclass, replace


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
        Time the shutter is open, centred on a frame's time; None: not stated.
    """

    frame_rate_hz: float
    height_px: int = 192
    width_px: int = 240
    front_view_rows: tuple[int, int] = (0, 192)
    top_view_rows: tuple[int, int] | None = None
    scale_px_per_m: float | None = None
    front_origin_px: tuple[float, float] | None = None
    top_origin_px: tuple[float, float] | None = None
    exposure_s: float | None = None

    @property
    def longest_exposure_s(self) -> float:
        """Time that the shutter may be open: from picture to picture, where none is stated."""
        return 1.0 / self.frame_rate_hz if self.exposure_s is None else self.exposure_s


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


MEMORY_RAD = 0.3
"""Of the thesis's markers, 4 mm on a sphere of an inch."""


@dataclass(frozen=True, slots=True)
class SlowErrors:
    """Errors of poses that no scatter betrays, as they last through a flight or a campaign.

    Attributes
    ----------
    position_m, rotation_rad
        Size of what the frames of one flight share, of a coordinate and about each axis; 0: none
        is stated.
    scale
        Relative standard error of the images' scale, by which lengths of all shots come out too
        long or too short together; 0: none is stated.
    memory_rad
        By how much a sphere turns while what the frames of a flight share lasts: what its markers
        are wide.
    one_body_frame
        Whether orientations are of one body frame for each sphere in all shots, so that all share
        what a pattern stands off its sphere.
    """

    position_m: float = 0.0
    rotation_rad: float = 0.0
    scale: float = 0.0
    one_body_frame: bool = True
    memory_rad: float = MEMORY_RAD

    @property
    def stated(self) -> bool:
        """Whether any is larger than zero."""
        return self.position_m > 0 or self.rotation_rad > 0 or self.scale > 0


NO_SLOW_ERRORS = SlowErrors()
DRAG_SIGMA = 0.2
"""Standard error of a stated drag coefficient where none is stated with it."""


@dataclass(frozen=True, slots=True)
class Setup:
    """Everything a shot's analysis needs beside its frames.

    `gravity_m_per_s2` acts along +X (down). Poses that were measured elsewhere may come with their
    slow errors. `drag_coefficient` is that of the spheres in air, F = rho/2 Cd A v^2, with its
    standard error; None: not stated.
    """

    camera: CameraSetup
    spheres: tuple[SphereSetup, SphereSetup]
    gravity_m_per_s2: float = 9.80665
    air_density_kg_per_m3: float = 1.2
    slow: SlowErrors = NO_SLOW_ERRORS
    drag_coefficient: float | None = None
    drag_sigma: float = DRAG_SIGMA


def without_exposure(setup: Setup) -> Setup:
    """Return the set-up as all shots share it: the exposure may change from one to the next."""
    return replace(setup, camera=replace(setup.camera, exposure_s=None))
