"""What measuring leaves in a campaign's poses: their slow errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from analysis.imaging.views import View
from analysis.motion.drift import centre_drift, turn_drift
from analysis.setup import Setup, SlowErrors
from analysis.tracking import Tracking

NARROWEST_RAD = 0.05
"""Of markers, where none is seen or they are points."""


def slow_errors(tracking: Tracking, setup: Setup, *, one_body_frame: bool) -> SlowErrors:
    """Return the slow errors of a tracked shot.

    The photometric method learns one pattern for a campaign, so that all shots have one body frame;
    the thesis's begins anew each time. The scale is off alike in all shots by either: one is
    learned, or the same light shifts all outlines alike; and lengths are as well known as the
    diameters are. A shot whose spheres did not look as
    learned has body axes of its own.
    """
    width, scale = tracking.filter_sigma_px, tracking.scales_px_per_m[View.FRONT]
    return SlowErrors(
        position_m=centre_drift(width, scale, 1.0).sigma,
        rotation_rad=turn_drift(width, min(tracking.radii[View.FRONT]), 1.0).sigma,
        shared_m=tracking.shared_px / scale,
        scale=math.hypot(tracking.scale_sigma, setup.length_sigma),
        one_body_frame=one_body_frame,
        memory_rad=max(2 * tracking.marker_angle, NARROWEST_RAD),
    )


def typical(setup: Setup, errors: Sequence[SlowErrors]) -> Setup:
    """Return the set-up with the medians of its shots' slow errors (decision 0004).

    Without any shot it is returned as it is.
    """
    if not errors:
        return setup
    slow = SlowErrors(
        position_m=float(np.median([each.position_m for each in errors])),
        rotation_rad=float(np.median([each.rotation_rad for each in errors])),
        shared_m=float(np.median([each.shared_m for each in errors])),
        scale=float(np.median([each.scale for each in errors])),
        one_body_frame=all(each.one_body_frame for each in errors),
        memory_rad=float(np.median([each.memory_rad for each in errors])),
    )
    return replace(setup, measurement=slow)
