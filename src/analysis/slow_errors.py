"""What measuring leaves in a campaign's poses: slow errors, and the axes that orientations have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from analysis.imaging.views import View
from analysis.motion.drift import centre_drift, turn_drift
from analysis.setup import Setup
from analysis.shot import MeasuredShot


def slow_errors(shot: MeasuredShot) -> tuple[float, float]:
    """Return the size of a shot's slow errors: of a coordinate, m, and about each axis, rad."""
    tracking = shot.tracking
    width, scale = tracking.filter_sigma_px, tracking.scales_px_per_m[View.FRONT]
    place = centre_drift(width, scale, 1.0)
    return place.sigma, turn_drift(width, min(tracking.radii[View.FRONT]), 1.0).sigma


def one_frame(shot: MeasuredShot) -> bool:
    """Return whether a shot's orientations are of a body frame that other shots share.

    The photometric method learns one pattern for a campaign; the thesis's begins anew each time.
    """
    return shot.known is not None


def typical(
    setup: Setup, errors: Sequence[tuple[float, float]], one_frames: Sequence[bool]
) -> Setup:
    """Return the set-up with the medians of its shots' slow errors (decision 0004).

    Without any shot it is returned as it is.

    Parameters
    ----------
    errors, one_frames
        What `slow_errors` and `one_frame` return of each shot.
    """
    if not errors:
        return setup
    place, turn = np.median(np.array(errors), axis=0)
    return replace(
        setup,
        slow_position_m=float(place),
        slow_rotation_rad=float(turn),
        one_body_frame=all(one_frames),
    )
