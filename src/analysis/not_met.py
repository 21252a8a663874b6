"""What became of two spheres whose contact was not seen: who leaves the view, whether they meet.

A shot without a contact is refused for what its tracks lack. What a person can mend is what
happened: a sphere that leaves the stated view, spheres that pass each other, a film that ends.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from analysis.arrays import Floats
from analysis.collision.instant import touching_time
from analysis.imaging.tracks import Track
from analysis.imaging.views import ViewGeometry, view_geometries
from analysis.motion.poses import Centres
from analysis.motion.velocity import DOWN
from analysis.setup import Setup
from analysis.shot_poses import Frames
from analysis.tracking import Tracking

LEAST_FRAMES, MOST_OFF = 3, 0.05
"""Frames with both spheres, and how far their places lie off free flight, over both radii."""
FILMS_OFF = 4.0
"""Lengths of the film in which what moves would have met."""


def what_happened(tracking: Tracking, setup: Setup, times_s: Floats) -> str:
    """Return what the tracks show, empty where they show nothing of it.

    Parameters
    ----------
    setup
        Of the frames that were followed.
    times_s
        From the first frame, shape (F,).
    """
    said = [*_leaving(tracking, setup, len(times_s)), *_meeting(tracking, setup, times_s)]
    return "; ".join(said)


def _leaving(tracking: Tracking, setup: Setup, frames: int) -> Iterator[str]:
    """Say which sphere's track ends at an edge of a view, and after which frame."""
    for name, sphere in zip("ab", tracking.spheres, strict=True):
        for geometry in view_geometries(setup.camera):
            track = sphere.get(geometry.view)
            if track is None or len(track.outlines) < 2 or max(track.outlines) >= frames - 1:
                continue
            edge = _crossed(track, geometry, setup.camera.width_px)
            if edge is not None:
                view, last = geometry.view.value, max(track.outlines)
                yield f"sphere {name} crosses the {edge} edge of the {view} view after frame {last}"
                break


def _crossed(track: Track, geometry: ViewGeometry, width_px: int) -> str | None:
    """Return the edge that a disc crosses in the frame after its last; None for none."""
    before, last = sorted(track.outlines)[-2:]
    first, second = track.outlines[before].circle, track.outlines[last].circle
    row = second.row + (second.row - first.row) / (last - before)
    column = second.column + (second.column - first.column) / (last - before)
    beyond = {
        "upper": geometry.rows[0] - (row - second.radius),
        "lower": row + second.radius - geometry.rows[1],
        "left": second.radius - column,
        "right": column + second.radius - width_px,
    }
    edge = max(beyond, key=lambda name: beyond[name])
    return edge if beyond[edge] > 0.0 else None


def _meeting(tracking: Tracking, setup: Setup, times_s: Floats) -> Iterator[str]:
    """Say whether the free flights that the tracks show meet, where, and when."""
    reach = setup.spheres[0].diameter_m / 2 + setup.spheres[1].diameter_m / 2
    lines = _lines(tracking.centres, times_s, setup.environment.gravity_m_per_s2, reach)
    if lines is None:
        return
    apart, relative, seen = lines
    wait = float(touching_time(apart[None], relative[None], np.array(reach))[0])
    nearest = -float(apart @ relative) / float(relative @ relative)
    if abs(nearest if math.isnan(wait) else wait) > FILMS_OFF * (times_s[-1] - times_s[0]):
        # What hardly moves in the whole film is no sphere that was fired.
        return
    if nearest < times_s[seen[0]] - times_s[seen[-1]]:
        yield (
            f"the spheres part already in frame {seen[0]}, the first that shows both: a contact "
            "would lie before it"
        )
    elif math.isnan(wait):
        closest = float(np.linalg.norm(apart + relative * nearest))
        yield (
            f"the spheres pass each other with {1e3 * (closest - reach):.2f} mm between them, "
            f"nearest {_when(nearest, seen, times_s)} ({1e3 * closest:.2f} mm between their "
            f"centres, they touch at {1e3 * reach:.2f} mm)"
        )
    elif wait > 0.0:
        yield f"the spheres would touch {_when(wait, seen, times_s)}"


def _when(since_s: float, seen: Frames, times_s: Floats) -> str:
    at = float(times_s[int(seen[-1])]) + since_s
    if at > times_s[-1]:
        return f"{1e3 * (at - times_s[-1]):.1f} ms after the last frame of the film"
    return f"in frame {int(np.abs(times_s - at).argmin())}"


def _lines(
    centres: tuple[Centres, Centres], times_s: Floats, gravity: float, reach: float
) -> tuple[Floats, Floats, Frames] | None:
    """Return where b is from a in the last frame that shows both, its velocity, and those frames.

    By straight lines through the frames that show both, gravity taken out; None for too few, or
    where they are no straight lines.
    """
    seen = np.intersect1d(centres[0].frames, centres[1].frames)
    if len(seen) < LEAST_FRAMES:
        return None
    tau = times_s[seen] - times_s[seen[-1]]
    states = []
    for own in centres:
        places = own.position[np.isin(own.frames, seen)]
        straight = np.nan_to_num(places) - 0.5 * gravity * DOWN * tau[:, None] ** 2
        speed, place = np.polyfit(tau, straight, 1)
        off = straight - place - tau[:, None] * speed
        if np.sqrt((off**2).sum(axis=1).mean()) > MOST_OFF * reach:
            return None
        states.append((place, speed))
    (place_a, speed_a), (place_b, speed_b) = states
    return place_b - place_a, speed_b - speed_a, seen
