"""Lamps beside the spheres: a bright and a dark side, gloss, and the shadows they cast."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Lamp:
    """A distant lamp and the light of the room.

    Grey level before the lens at a point with unit normal n, seen along the unit vector v toward
    the eye: `room` (1 - `limb_darkening` (1 - v . n)) + lit (`strength` max(n . s, 0) + `gloss`
    max(r . v, 0)^`sharpness`), with s toward the lamp and r the mirrored s; all of it times
    1 + `uneven_per_m` . point. What stands between a point and the lamp takes the lamp's light.

    Parameters
    ----------
    toward
        Direction from the rig to the lamp, rig axes; of any length.
    strength, room, gloss
        Grey levels.
    limb_darkening
        Of the room's light.
    sharpness
        Exponent of the highlight (Phong); a larger one is a smaller highlight.
    width_rad
        Angle under which the lamp appears: the width of the edge of a shadow.
    uneven_per_m
        Relative slope of all light along X, Y, Z.
    mirror_edge_m
        Z of the mirror's edge toward the camera: the mirror above takes the light of a steep lamp
        behind it. None: the mirror casts no shadow.
    fill
        A second lamp, with its own share of the room's light; None: there is none.
    """

    toward: tuple[float, float, float] = (-0.35, -0.80, 0.50)
    strength: float = 150.0
    room: float = 20.0
    gloss: float = 0.0
    limb_darkening: float = 0.2
    sharpness: float = 40.0
    width_rad: float = 0.05
    uneven_per_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mirror_edge_m: float | None = None
    fill: Lamp | None = None

    @property
    def all(self) -> tuple[Lamp, ...]:
        """The lamp and those that fill in."""
        return (self,) if self.fill is None else (self, *self.fill.all)

    @property
    def direction(self) -> Floats:
        """Unit vector (3,) toward the lamp, rig axes."""
        vector = np.array(self.toward)
        return np.asarray(vector / np.linalg.norm(vector))

    def grey(self, normal: Floats, eye: Floats, lit: Floats) -> tuple[Floats, Floats]:
        """Return light that markers swallow and the gloss above them, each of shape (...).

        Parameters
        ----------
        normal, eye
            Unit vectors (..., 3) in rig axes: of the surface, and toward the eye.
        lit
            Share of the lamp that is seen from the point, 0 to 1, shape (...).
        """
        toward = self.direction
        facing, lamp = (normal * eye).sum(axis=-1), normal @ toward
        mirrored = 2.0 * lamp * facing - eye @ toward
        room = self.room * (1.0 - self.limb_darkening * (1.0 - facing))
        bright = self.strength * np.maximum(lamp, 0.0)
        gloss = self.gloss * np.maximum(mirrored, 0.0) ** self.sharpness
        return room + lit * bright, lit * np.where(lamp > 0.0, gloss, 0.0)

    def seen_past(self, points: Floats, centre: Floats, radius_m: float) -> Floats:
        """Return the share of the lamp that a sphere leaves to points (..., 3), shape (...)."""
        to_centre = centre - points
        along = to_centre @ self.direction
        miss = np.sqrt(np.maximum((to_centre**2).sum(axis=-1) - along**2, 0.0)) - radius_m
        soft = np.maximum(along, 1e-9) * self.width_rad
        return np.where(along > 0.0, np.clip(miss / soft + 0.5, 0.0, 1.0), 1.0)

    def seen_past_mirror(self, points: Floats, mirror_m: float) -> Floats:
        """Return the share of the lamp that the mirror leaves to points (..., 3), shape (...).

        Parameters
        ----------
        mirror_m
            Height of the mirror's plane X + Z = -`mirror_m` above the origin.
        """
        toward = self.direction
        if self.mirror_edge_m is None or toward[0] + toward[2] >= 0.0:
            return np.ones(points.shape[:-1])
        way = -(mirror_m + points[..., 0] + points[..., 2]) / (toward[0] + toward[2])
        beyond = points[..., 2] + way * toward[2] - self.mirror_edge_m
        soft = np.maximum(way, 1e-9) * self.width_rad
        return np.where(way > 0.0, np.clip(beyond / soft + 0.5, 0.0, 1.0), 1.0)
