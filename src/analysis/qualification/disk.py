"""Angles of a turning disk: table 6.2 and figure 6.2 of the thesis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats, Grey
from analysis.errors import ShotRefusedError
from analysis.imaging.edge.edges import laplacian_of_gaussian
from analysis.imaging.edge.expansion import expanded_zero_crossings
from analysis.imaging.edge.facet import zero_crossing_pixels
from analysis.imaging.edge.frame import gradient_threshold, noise_sd
from analysis.imaging.edge.labels import label_connected
from analysis.imaging.ellipse_shells import fit_ellipse
from analysis.motion.proximal import match_markers
from analysis.qualification.drop import Method
from analysis.qualification.grey_discs import fit_grey_discs
from analysis.qualification.locating import THESIS_SIGMA_PX

SAMPLES = 4
SMALLEST_PX, LARGEST_PX = 2.0, 15.0
ROUNDNESS = 0.6
LEAST_MARKERS = 2
REACH_PX = 20.0
"""A marker goes less far in a frame."""
MOST_STEPS = 7
"""The thesis's table ends at seven frames apart."""


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """Angles between frames that lie `steps` apart.

    Attributes
    ----------
    steps
        Number of frames between the two.
    actual
        True angle, degrees.
    angles
        Measured, degrees, shape (pairs,).
    """

    steps: int
    actual: float
    angles: Floats

    @property
    def mean(self) -> float:
        """Mean angle, degrees."""
        return float(self.angles.mean())

    @property
    def deviation(self) -> float:
        """Standard deviation, degrees."""
        return float(self.angles.std(ddof=1))

    @property
    def relative_error(self) -> float:
        """(mean - actual) / actual, as table 6.2 prints it; its footnote has the other sign."""
        return self.mean / self.actual - 1.0


def measure_disk(frames: Grey, turn_rad: float, method: Method) -> list[Turn]:
    """Measure the turns between all frames up to seven apart.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns), the disk seen square on.
    turn_rad
        True angle from frame to frame, radians.

    Raises
    ------
    ShotRefusedError
        Too few markers are seen through all frames.
    """
    markers = disk_markers(frames, method)
    return [
        Turn(
            steps=steps,
            actual=float(np.degrees(steps * turn_rad)),
            angles=np.degrees(
                [plane_angle(a, b) for a, b in zip(markers[:-steps], markers[steps:], strict=True)]
            ),
        )
        for steps in range(1, min(MOST_STEPS, len(frames) - 2) + 1)
    ]


def plane_angle(before: Floats, after: Floats) -> float:
    """Return the angle, radians, that turns one set of points into the other, by least squares.

    Minimises sum |after - c' - R (before - c)|^2 over the angle and both centres, which are the
    means (section 5.2 of the thesis in one plane).

    Parameters
    ----------
    before, after
        (row, column) of the same points, shape (points, 2). Positive from rows to columns.
    """
    a, b = before - before.mean(axis=0), after - after.mean(axis=0)
    sine = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()
    return float(np.arctan2(sine, (a * b).sum()))


def disk_markers(frames: Grey, method: Method) -> Floats:
    """Return the centres of the markers that all frames show, in one order.

    Edges at quarters of a pixel, labels, fuzzy shells for ellipses, proximal uniformity; the
    photometric method fits the grey levels of each marker from there.

    Returns
    -------
    (row, column) in pixels, shape (frames, markers, 2).

    Raises
    ------
    ShotRefusedError
        Fewer than two markers are seen through all frames.
    """
    noise = noise_sd(frames)
    seen = [dark_ellipses(frame, noise) for frame in frames]
    names = match_markers([markers[:, :2] for markers in seen], REACH_PX)
    kept = sorted(set.intersection(*(set(own.tolist()) for own in names)))
    if len(kept) < LEAST_MARKERS:
        raise ShotRefusedError(
            "markers",
            f"{len(kept)} markers are seen in all {len(frames)} frames, {LEAST_MARKERS} are needed",
        )
    tracks = np.array(
        [
            [markers[np.flatnonzero(own == name)[0]] for name in kept]
            for markers, own in zip(seen, names, strict=True)
        ]
    )
    if method == "thesis":
        return np.asarray(tracks[:, :, :2])
    fitted = [
        fit_grey_discs(frames, [tuple(place) for place in track], shaded=False).centres
        for track in tracks.transpose(1, 0, 2).tolist()
    ]
    return np.stack(fitted, axis=1)


def dark_ellipses(frame: Grey, noise: float) -> Floats:
    """Find small dark discs on a bright ground.

    Returns
    -------
    Row, column and mean radius, pixels, shape (markers, 3).
    """
    edges = laplacian_of_gaussian(frame, THESIS_SIGMA_PX)
    threshold = gradient_threshold(noise, THESIS_SIGMA_PX)
    labels = label_connected(zero_crossing_pixels(edges, threshold))
    points = expanded_zero_crossings(edges, threshold, SAMPLES)
    own = labels[points.pixel_row, points.pixel_column]
    found = []
    for label in range(1, int(labels.max()) + 1):
        curve = points.where(own == label)
        ellipse = fit_ellipse(curve.row, curve.column)
        if ellipse is None or ellipse.semi_minor < ROUNDNESS * ellipse.semi_major:
            continue
        outward = (curve.row - ellipse.row) * curve.normal_row
        outward += (curve.column - ellipse.column) * curve.normal_column
        radius = float(np.sqrt(ellipse.semi_major * ellipse.semi_minor))
        if outward.mean() > 0 and SMALLEST_PX < radius < LARGEST_PX:
            found.append((ellipse.row, ellipse.column, radius))
    return np.array(found).reshape(-1, 3)
