"""Where a sphere appears in each view, and how its image moves with it.

One pinhole sees both views; the mirror makes it a second one, farther away. A sphere near a pinhole
shows less than half of itself. Turning every direction m on it to (b m_across, m_z - h) / (1 -
h m_z), with h the radius over the distance, b^2 = 1 - h^2 and z towards the eye, gives the sphere
that looks the same from infinity; caps stay caps (a conformal map of the sphere), so that all
drawing is done as from infinity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled
from analysis.imaging.views import View, view_geometries
from analysis.setup import CameraSetup

FAR = -1e6
BENT = 7
"""What a fault of the camera changes in a view of a sphere: row, column, turns about row, column
and eye, log radius of the limb and of the sphere that the markers lie on."""
KEPT_ROUNDS = 4
"""Each leaves some hundredth of the error before it."""


class Optics(NamedTuple):
    """The views of a camera as compiled functions take them, V of them, the front view first.

    Attributes
    ----------
    axes
        Directions of increasing row, increasing column, and towards the eye, shape (V, 3, 3).
    origins
        Row and column of the rig's origin, pixels, shape (V, 2).
    scales
        Pixels per metre, shape (V,).
    hands
        1 where those axes are right-handed, -1 in a mirror, shape (V,).
    rows
        Half-open range of rows that may show the view, shape (V, 2).
    nearness
        Inverse of the distance from the pinhole to the rig's origin in the front view, 1/m; the
        other views have it in proportion to their scales, the focal length being one.
    middle
        Row and column where the pinhole's axis meets the frame.
    """

    axes: Floats
    origins: Floats
    scales: Floats
    hands: Floats
    rows: NDArray[np.int64]
    nearness: float = 0.0
    middle: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """The views of a camera with what has been measured of them."""

    views: tuple[View, ...]
    optics: Optics

    def with_scales(self, scales: Floats) -> Camera:
        """Return the camera with other scales, px/m, shape (V,)."""
        return replace(self, optics=self.optics._replace(scales=scales))

    def with_origins(self, origins: Floats) -> Camera:
        """Return the camera with the rig's origin at other pixels, shape (V, 2)."""
        return replace(self, optics=self.optics._replace(origins=origins))

    def with_nearness(self, nearness: float) -> Camera:
        """Return the camera at another distance, given by its inverse, 1/m."""
        return replace(self, optics=self.optics._replace(nearness=nearness))

    def with_shifted_mirror(self, columns_px: float) -> Camera:
        """Return the camera with the rig's origin in the mirror's view at other columns."""
        shift = np.outer(np.arange(len(self.views)) > 0, [0.0, columns_px])
        return self.with_origins(self.optics.origins + shift)

    def at_pixels(self, view: int, place: tuple[float, float], towards_m: float) -> Floats:
        """Return the offset along row and column from the rig's origin of a pixel, m, shape (2,).

        Parameters
        ----------
        place
            Row and column.
        towards_m
            Place of the point towards the eye.
        """
        optics = self.optics
        near = 1.0 - own_nearness(optics, view) * towards_m
        middle = np.array(optics.middle)
        offset = (np.array(place) - middle) * near + middle - optics.origins[view]
        return np.asarray(offset / optics.scales[view])


def camera_of(setup: CameraSetup, scales: Floats) -> Camera:
    """Return the camera of a set-up, orthographic, with the scale of each view in px/m.

    The front view may reach into the rows of the top view: a sphere stands before the mirror.
    """
    views = view_geometries(setup)
    axes = np.stack([geometry.offsets(np.eye(3)).T for geometry in views])
    rows = [(0, setup.height_px)] + [geometry.rows for geometry in views[1:]]
    optics = Optics(
        axes=np.ascontiguousarray(axes),
        origins=np.array([geometry.origin for geometry in views], dtype=np.float64),
        scales=np.asarray(scales, dtype=np.float64),
        hands=np.sign(np.linalg.det(axes)),
        rows=np.array(rows, dtype=np.int64),
        middle=((setup.height_px - 1) / 2, (setup.width_px - 1) / 2),
    )
    return Camera(tuple(geometry.view for geometry in views), optics)


@compiled
def own_nearness(optics: Optics, view: int) -> float:
    """Return the inverse of the distance from a view's pinhole to the rig's origin, 1/m."""
    return float(optics.nearness * optics.scales[view] / optics.scales[0])


@compiled
def nearer(optics: Optics, view: int, centre: Floats) -> float:
    """Return the distance from a view's pinhole to a point over that to the rig's origin."""
    towards = 0.0
    for k in range(3):
        towards += optics.axes[view, 2, k] * centre[k]
    return 1.0 - own_nearness(optics, view) * towards


@compiled
def disc_of(
    optics: Optics, view: int, centre: Floats, radius_m: float
) -> tuple[float, float, float]:
    """Return row, column and radius of a sphere's disc, pixels."""
    axes, scale = optics.axes[view], optics.scales[view]
    row = optics.origins[view, 0] - optics.middle[0]
    column = optics.origins[view, 1] - optics.middle[1]
    for k in range(3):
        row += scale * axes[0, k] * centre[k]
        column += scale * axes[1, k] * centre[k]
    near = nearer(optics, view, centre)
    return row / near + optics.middle[0], column / near + optics.middle[1], scale * radius_m / near


@compiled
def axes_at(optics: Optics, view: int, centre: Floats) -> Floats:
    """Return the axes of a view at a point: row, column and towards the eye from it, (3, 3).

    To first order in the angle from the pinhole's axis, which is 0.05 at most.
    """
    row, column, _ = disc_of(optics, view, centre, 0.0)
    per_px = own_nearness(optics, view) / optics.scales[view]
    down, across = (row - optics.middle[0]) * per_px, (column - optics.middle[1]) * per_px
    axes = optics.axes[view]
    own = np.empty((3, 3))
    for k in range(3):
        own[0, k] = axes[0, k] + down * axes[2, k]
        own[1, k] = axes[1, k] + across * axes[2, k]
        own[2, k] = axes[2, k] - down * axes[0, k] - across * axes[1, k]
    for a in range(3):
        length = math.sqrt(own[a, 0] ** 2 + own[a, 1] ** 2 + own[a, 2] ** 2)
        for k in range(3):
            own[a, k] /= length
    return own


@compiled
def moved_by(optics: Optics, view: int, centre: Floats) -> Floats:
    """Return the derivative of row and column to the centre, pixels per metre, shape (2, 3)."""
    row, column, _ = disc_of(optics, view, centre, 0.0)
    near, own = nearer(optics, view, centre), own_nearness(optics, view)
    change = np.empty((2, 3))
    for k in range(3):
        pull = own * optics.axes[view, 2, k] / near
        change[0, k] = optics.scales[view] * optics.axes[view, 0, k] / near
        change[0, k] += (row - optics.middle[0]) * pull
        change[1, k] = optics.scales[view] * optics.axes[view, 1, k] / near
        change[1, k] += (column - optics.middle[1]) * pull
    return change


@compiled
def place_covariances(optics: Optics, view: int, centres: Floats, covariances: Floats) -> Floats:
    """Return the covariances of row and column in a view, px^2, shape (n, 2, 2).

    Parameters
    ----------
    centres, covariances
        m, shape (n, 3), and of centre and turn, m^2 and rad^2, shape (n, 6, 6).
    """
    places = np.zeros((centres.shape[0], 2, 2))
    for n in range(centres.shape[0]):
        moved = moved_by(optics, view, centres[n])
        for a in range(2):
            for b in range(2):
                for i in range(3):
                    for j in range(3):
                        places[n, a, b] += moved[a, i] * covariances[n, i, j] * moved[b, j]
    return places


@compiled
def keep_places(old: Optics, new: Optics, centres: Floats) -> None:
    """Move centres, m, shape (n, 3), so that another camera shows them in place.

    The front view places X and Y, the last view Z.
    """
    last = new.scales.shape[0] - 1
    for n in range(centres.shape[0]):
        front, above = disc_of(old, 0, centres[n], 0.0), disc_of(old, last, centres[n], 0.0)
        for _ in range(KEPT_ROUNDS):
            place = disc_of(new, 0, centres[n], 0.0)
            centres[n, 0] += (front[0] - place[0]) / new.scales[0]
            centres[n, 1] += (front[1] - place[1]) / new.scales[0]
            if last > 0:
                centres[n, 2] -= (above[0] - disc_of(new, last, centres[n], 0.0)[0]) / new.scales[1]


def by_nearness(optics: Optics, view: int, centre: Floats) -> Floats:
    """Return the change of an image with the camera's nearness, per 1/m, shape (BENT, 1)."""
    row, column, _ = disc_of(optics, view, centre, 0.0)
    towards = float(optics.axes[view, 2] @ centre) / nearer(optics, view, centre)
    share = towards * optics.scales[view] / optics.scales[0]
    change = np.zeros((BENT, 1))
    change[:2, 0] = (row - optics.middle[0]) * share, (column - optics.middle[1]) * share
    # Limb and markers alike are farther from the middle.
    change[BENT - 2 :, 0] = share
    return change


def by_nearness_and_shift(optics: Optics, view: int, centre: Floats) -> Floats:
    """Return the change with the nearness and with a mirror's columns, (BENT, 2): 1/m and px."""
    shift = np.zeros((BENT, 1))
    shift[1] = float(view > 0)
    return np.hstack([by_nearness(optics, view, centre), shift])


@compiled
def discs_of(optics: Optics, centres: Floats, radii_m: Floats, placed: NDArray[np.bool_]) -> Floats:
    """Return row, column and radius of all discs of some frames.

    Parameters
    ----------
    centres, radii_m, placed
        m, shape (spheres, F, 3); m, shape (spheres,); whether there is a pose, (spheres, F).

    Returns
    -------
    Shape (F, spheres V, 3), those of the first sphere first; far away and without size where
    there is no pose.
    """
    views = optics.scales.shape[0]
    discs = np.empty((centres.shape[1], centres.shape[0] * views, 3))
    for k in range(centres.shape[1]):
        for i in range(centres.shape[0]):
            for view in range(views):
                place = disc_of(optics, view, centres[i, k], radii_m[i])
                if not placed[i, k]:
                    place = (FAR, FAR, 0.0)
                for n in range(3):
                    discs[k, views * i + view, n] = place[n]
    return discs
