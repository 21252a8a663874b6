"""Frames of a shot to poses by rendering: learn the spheres, then fit every frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.frame import EdgeSettings
from analysis.photometric.appearance import Knowledge
from analysis.photometric.film import fit_film
from analysis.photometric.learning import learn
from analysis.photometric.result import tracking_of
from analysis.photometric.start import first_film
from analysis.setup import Setup
from analysis.tracking import Tracking, track_spheres

Floats = NDArray[np.float64]

LAST_LIMITS = (6.0, 6.0)


def measure_poses(
    frames: NDArray[np.uint8], times_s: Floats, setup: Setup
) -> tuple[Tracking, Knowledge]:
    """Measure the poses of both spheres at the noise limit.

    Outlines and markers (`tracking.track_spheres`) give the start; the spheres' look is learned
    from the shot itself.

    Raises
    ------
    ShotRefusedError
        With the step, the frame and the reason.
    """
    start = track_spheres(frames, times_s, setup, EdgeSettings(), "pattern")
    film, guess = first_film(frames, times_s, start, setup)
    known = learn(film, guess, hold_scale=setup.camera.scale_px_per_m is not None)
    fit_film(film, known, np.array(LAST_LIMITS))
    return tracking_of(film, known), known
