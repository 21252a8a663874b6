"""What is known of a flight before a film is seen, each with how well: priors of the fit."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.setup import Setup

DRAG_COEFFICIENT, DRAG_SIGMA = 0.47, 0.05
"""Of a smooth sphere at Reynolds numbers of 10^3 to 2 10^5 (Clift, Grace and Weber, 1978)."""
AIR_DENSITY = 1.2
UNKNOWN_DENSITY, UNKNOWN_SPREAD = 400.0, 1.0
"""kg/m^3 of a tennis ball, and the spread of the logarithm: one spread above lie solid balls of
rubber or plastic (1100), one and a half below those full of air (table tennis, football: 75 to 85).
With a wider one the drag of slow films runs away."""
DIAMETER_RIM_SIGMA = 0.01
"""Relative: what shading and codecs do to a rim."""
LEVEL_SIGMA, ROLL_SIGMA = 0.005, 0.05
"""rad, of a floor, table or plate that is laid level, and of a camera that stands by eye."""
SMEAR_SIGMA = 0.005
"""By which part of its smear a ball's centre comes out too high or too low: its light is uneven."""
BARREL_SIGMA = 0.01
"""Of a lens, at half the picture's larger side."""
LOOK_SIGMA = 0.1
"""rad, of a camera's line of sight against the plane of the flight."""
NEAREST_M, VIEWS_AWAY, AWAY_SPREAD = 0.4, 1.6, 0.8
"""Distance of a camera, where no focal length is stated: NEAREST_M plus VIEWS_AWAY times the larger
side of the field of view. That fits a long lens before a bench and a telephone before a room. And
the spread of the distance's logarithm."""
DRIFT_SHARE = 0.02
"""Of a dropped ball's speed: how much of it is sideways at least."""
FRICTION_LEAVES = 3.0 / 5.0
"""Of the speed across of a hollow ball that begins to roll, without spin before; a solid one keeps
5/7."""
READOUT_SHARE = 0.5, 0.3
"""Of the time between frames: the middle and the spread of what rolling shutters take to read a
frame."""
SHORTENING, SHORTENING_SIGMA = 0.15, 0.1
"""Power of the approach speed by which contacts last shorter: solid balls have 1/5, linear springs,
and balls that are full of air, hardly any."""


@dataclass(frozen=True, slots=True)
class Ball:
    """What a person states of the ball.

    Attributes
    ----------
    diameter_m, diameter_sigma
        Diameter in m and its relative standard error.
    density
        kg/m^3; None: not stated.
    drag_coefficient, drag_sigma
        In air, with its standard error.
    air_density
        kg/m^3.
    gravity
        m/s^2.
    plate_lean
        Angle of the plate against the horizontal, rad, positive where it lies lower on the right;
        None: not stated, and level unless several bounces show that it is not.
    """

    diameter_m: float
    diameter_sigma: float = 0.0
    density: float | None = None
    drag_coefficient: float = DRAG_COEFFICIENT
    drag_sigma: float = DRAG_SIGMA
    air_density: float = AIR_DENSITY
    gravity: float = 9.80665
    plate_lean: float | None = None

    def __str__(self) -> str:
        """Return size, mass and surroundings in a person's units."""
        grams = None if self.density is None else 1e3 * self.density * self.diameter_m**3
        mass = "unknown mass" if grams is None else f"{math.pi / 6.0 * grams:.4g} g"
        return (
            f"{1e3 * self.diameter_m:.4g} mm and {mass} with a drag coefficient of "
            f"{self.drag_coefficient:.3g} in air of {self.air_density:.4g} kg/m^3, "
            f"gravity {self.gravity:.6g} m/s^2"
        )

    @classmethod
    def of_setup(cls, setup: Setup) -> Ball:
        """Return sphere a of a set-up in its surroundings; air that is not stated is the usual."""
        sphere, around = setup.spheres[0], setup.environment
        drag = around.drag_coefficient
        return cls(
            diameter_m=sphere.diameter_m,
            density=sphere.density_kg_per_m3,
            drag_coefficient=drag or DRAG_COEFFICIENT,
            drag_sigma=around.drag_coefficient_sigma if drag else DRAG_SIGMA,
            air_density=around.air_density_kg_per_m3,
            gravity=around.gravity_m_per_s2,
            plate_lean=plate_lean(setup),
        )

    def drag_per_m(self) -> tuple[float, float]:
        """Return k of a = k v^2 in 1/m, and the standard error of its logarithm."""
        density = UNKNOWN_DENSITY if self.density is None else self.density
        drag = 0.75 * self.air_density * self.drag_coefficient / (density * self.diameter_m)
        spread = self.drag_sigma / self.drag_coefficient
        if self.density is None:
            spread = math.hypot(spread, UNKNOWN_SPREAD)
        return drag, spread


def plate_lean(setup: Setup) -> float | None:
    """Return the stated angle of a set-up's plate against the horizontal, as `Ball` has it.

    Normals are from the sphere into the plate, with X downward and Y to the right.
    """
    normal = setup.spheres[1].normal
    return None if normal is None else math.atan2(-normal[1], normal[0])


@dataclass(frozen=True, slots=True)
class View:
    """What is known of how the film was taken.

    Attributes
    ----------
    height, width
        Of the camera's whole picture, px.
    period_s
        Time between frames.
    exposure_s
        Time the shutter is open.
    readout
        "rows" or "columns": read one after another; "global": all at once.
    row_time_s
        Stated time from one row to the next; None: fitted.
    focal_px
        Focal length and its standard error; None: not known.
    principal_px
        Principal point, (row, column) of the part of the picture that is looked at; None: the whole
        picture's middle.
    compressed
        Whether a codec has been at the pictures.
    readout_share
        Middle and spread of the time that it takes to read a frame, of the time between frames.
    """

    height: int
    width: int
    period_s: float
    exposure_s: float
    readout: str = "global"
    row_time_s: float | None = None
    focal_px: tuple[float, float] | None = None
    principal_px: tuple[float, float] | None = None
    compressed: bool = False
    readout_share: tuple[float, float] = READOUT_SHARE

    def principal(self) -> tuple[float, float]:
        """Return row and column of the principal point."""
        return self.principal_px or (0.5 * (self.height - 1), 0.5 * (self.width - 1))

    def aslant(self, scale_px_per_m: float) -> tuple[float, float]:
        """Return the logarithm of the squared larger side over the focal length, and its error.

        Without a stated focal length it follows from the field of view over the camera's distance,
        which is the same ratio.

        Parameters
        ----------
        scale_px_per_m
            Of the picture, by the ball's diameter.
        """
        side = max(self.height, self.width)
        if self.focal_px is not None:
            focal, sigma = self.focal_px
            return 2.0 * math.log(side / focal), 2.0 * sigma / focal
        seen_m = side / scale_px_per_m
        distance = NEAREST_M + VIEWS_AWAY * seen_m
        return 2.0 * math.log(seen_m / distance), 2.0 * AWAY_SPREAD

    def per_focal(self, scale_px_per_m: float) -> float:
        """Return the root mean square of one over the focal length, 1/px."""
        middle, spread = self.aslant(scale_px_per_m)
        return math.exp(0.5 * middle + 0.25 * spread**2) / max(self.height, self.width)

    def row_time(self) -> tuple[float, float]:
        """Return the time a row is read after the one above, and its standard error, s."""
        if self.row_time_s is not None:
            return self.row_time_s, 0.0
        if self.readout == "global":
            return 0.0, 0.0
        lines = self.height if self.readout == "rows" else self.width
        middle, spread = self.readout_share
        return middle * self.period_s / lines, spread * self.period_s / lines

    def receding_sigma(self, before: Floats, after: Floats, per_focal: float) -> float:
        """Return the standard error of a ball's speed away from the camera, camera distances a s.

        A ball drifts along the line of sight as it does across the picture.

        Parameters
        ----------
        before, after
            Speeds at the bounces (row, column), px/s, shape (B, 2).
        per_focal
            One over the focal length, 1/px.
        """
        across = np.concatenate([before[:, 1], after[:, 1]])
        down = np.abs(np.concatenate([before[:, 0], after[:, 0]]))
        drift = math.hypot(float(np.sqrt((across**2).mean())), DRIFT_SHARE * float(down.mean()))
        return drift * per_focal

    def receding_by_spin(self, before: Floats, after: Floats, per_focal: float) -> Floats:
        """Return how much of a speed away from the camera spins give at bounces, shape (B,).

        As much as across the picture, where friction alone leaves between 3/5 and all of a speed.
        Distances of the camera a second.

        Parameters
        ----------
        before, after
            Speeds at the bounces (row, column), px/s, shape (B, 2).
        per_focal
            One over the focal length, 1/px.
        """
        slowed = FRICTION_LEAVES * before[:, 1]
        least, most = np.minimum(slowed, before[:, 1]), np.maximum(slowed, before[:, 1])
        gained = np.abs(after[:, 1] - np.clip(after[:, 1], least, most))
        return np.asarray(gained * per_focal)


@dataclass(frozen=True, slots=True)
class Known:
    """All that is known before the flights are fitted.

    Attributes
    ----------
    ball, view
        What is stated.
    radius_px, radius_sigma_px
        Of the ball in the picture.
    drag
        In 1/m, and the spread of its logarithm, where flights have told more of it than is stated
        of the ball.
    """

    ball: Ball
    view: View
    radius_px: float
    radius_sigma_px: float = 0.0
    drag: tuple[float, float] | None = None

    @property
    def misled_by_sizes(self) -> bool:
        """Return whether sizes would be taken for drifts, and these for a drag that nothing tells.

        In a compressed film sizes follow smears and grounds beside the ball's distance; drifts bend
        flights as drag does, which the mass of a ball would tell.
        """
        return self.ball.density is None and self.view.compressed

    def outline_sigma(self) -> float:
        """Return the relative standard error of the radius."""
        return self.radius_sigma_px / self.radius_px

    def scale(self) -> tuple[float, float]:
        """Return px/m by the ball's diameter, and its relative standard error."""
        sigmas = DIAMETER_RIM_SIGMA, self.ball.diameter_sigma, self.outline_sigma()
        return 2.0 * self.radius_px / self.ball.diameter_m, math.hypot(*sigmas)
