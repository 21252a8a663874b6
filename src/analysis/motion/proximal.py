"""Markers matched from frame to frame by proximal uniformity, and the orientation by such steps.

As the thesis has it (appendix B), kept for comparison with `pattern`.

K. Rangarajan and M. Shah, "Establishing motion correspondence", CVGIP: Image Understanding 54,
56-73 (1991), doi:10.1016/1049-9660(91)90075-Z. Small, smooth steps are preferred. Rigidity of the
sphere is not used, and markers close to each other can be exchanged.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.errors import ShotRefusedError, counted
from analysis.imaging.marker.markers import FilmMarkers, Markers
from analysis.motion.alignment import rotation_from_directions
from analysis.motion.pattern import Orientations, sightings
from analysis.motion.pattern_steps import LEAST_COMMON, average_pattern, orientation_covariances

Indices = NDArray[np.intp]

MOST_GUESSES = 2
"""A marker out of sight is extrapolated over this many frames, then forgotten."""


def proximal_uniformity(before: Floats, now: Floats, following: Floats) -> Floats:
    """Return the cost of going on from each present point to each following one.

    delta = |step - last step| / sum |step - last step| + |step| / sum |step|, the sums over all
    pairs; 0 for a point that goes on as it came, without moving.

    Parameters
    ----------
    before, now
        The same points in the last and the present frame, pixels relative to the sphere's centre,
        shape (points, 2).
    following
        Points of the next frame in any order, shape (candidates, 2).

    Returns
    -------
    Shape (points, candidates).
    """
    step = following[None, :, :] - now[:, None, :]
    change = np.linalg.norm(step - (now - before)[:, None, :], axis=2)
    length = np.linalg.norm(step, axis=2)
    return np.asarray(change / max(change.sum(), 1e-12) + length / max(length.sum(), 1e-12))


def assign(cost: Floats) -> Indices:
    """Give each candidate to at most one point, the most clear-cut first.

    Each candidate names its cheapest point; the pair whose loss would cost the others most (the
    sum of its row and column without it) is taken, its row and column are struck out, and so on.

    Parameters
    ----------
    cost
        Shape (points, candidates).

    Returns
    -------
    For each point its candidate, -1 where it has none, shape (points,).
    """
    chosen = np.full(cost.shape[0], -1, dtype=np.intp)
    rows, columns = list(range(cost.shape[0])), list(range(cost.shape[1]))
    while rows and columns:
        open_cost = cost[np.ix_(rows, columns)]
        cheapest = open_cost.argmin(axis=0)
        own = open_cost[cheapest, np.arange(len(columns))]
        priority = open_cost.sum(axis=0) + open_cost.sum(axis=1)[cheapest] - 2 * own
        best = int(priority.argmax())
        row = rows[int(cheapest[best])]
        chosen[row] = columns[best]
        rows.remove(row)
        columns.pop(best)
    return chosen


def match_markers(frames: list[Floats], reach_px: float) -> list[Indices]:
    """Name the markers of successive frames.

    The first two frames are matched by nearness, which must be right: the method starts from a
    known correspondence. A marker without a successor is extrapolated, x(k+1) = 2 x(k) - x(k-1),
    for two frames at most.

    Parameters
    ----------
    frames
        Markers of one view in each frame, pixels relative to the sphere's centre, each of shape
        (markers, 2).
    reach_px
        Nothing moves further than this in one frame.

    Returns
    -------
    For each frame the name of each marker, 0, 1, ...; one name for the whole sequence.
    """
    if not frames:
        return []
    names: list[Indices] = [np.arange(len(frames[0]), dtype=np.intp)]
    tracked = [_Tracked(name, point, point) for name, point in enumerate(frames[0])]
    fresh = len(tracked)
    for following in frames[1:]:
        named = np.full(len(following), -1, dtype=np.intp)
        chosen = np.full(len(tracked), -1, dtype=np.intp)
        if tracked and len(following):
            before = np.array([t.before for t in tracked])
            now = np.array([t.now for t in tracked])
            chosen = assign(proximal_uniformity(before, now, following))
        for marker, candidate in zip(list(tracked), chosen, strict=True):
            if candidate >= 0 and _near(marker.now, following[candidate], reach_px):
                marker.go_on(following[candidate])
                named[candidate] = marker.name
            elif not marker.guess():
                tracked.remove(marker)
        for candidate in np.flatnonzero(named < 0):
            named[candidate] = fresh
            tracked.append(_Tracked(fresh, following[candidate], following[candidate]))
            fresh += 1
        names.append(named)
    return names


class _Tracked:
    """A marker followed from frame to frame."""

    def __init__(self, name: int, before: Floats, now: Floats) -> None:
        self.name, self.before, self.now, self.guesses = name, before, now, 0

    def go_on(self, point: Floats) -> None:
        self.before, self.now, self.guesses = self.now, point, 0

    def guess(self) -> bool:
        self.before, self.now = self.now, 2 * self.now - self.before
        self.guesses += 1
        return self.guesses <= MOST_GUESSES


def _near(first: Floats, second: Floats, reach_px: float) -> bool:
    return bool(np.hypot(*(second - first)) <= reach_px)


REACH = 0.4
"""Markers move by less than this share of the radius in one frame."""


def orient_by_steps(seen: FilmMarkers, radius_px: float, sphere: str) -> Orientations:
    """Turn the sphere from frame to frame by the markers that two frames share.

    Every step adds its error to all that follow, and only the front view takes part.

    Parameters
    ----------
    seen
        Markers of one sphere; those of the front view are used.
    radius_px
        Radius of the sphere in the front view.
    sphere
        Its name, for the reason of a refusal.

    Raises
    ------
    ShotRefusedError
        Two neighbouring frames share fewer than three markers.
    """
    front = seen.where(seen.every.front)
    frames = front.frames.tolist()
    found = [front.every.where(own) for own in front.spans()]
    # Place of each against the disc's centre, pixels (row, column).
    points = [radius_px * markers.directions[:, :2] for markers in found]
    names = match_markers(points, REACH * radius_px)
    rotation = [np.eye(3)]
    for i in range(1, len(frames)):
        step = _step(found[i - 1], names[i - 1], found[i], names[i])
        if step is None:
            common = np.intersect1d(names[i - 1], names[i]).size
            raise ShotRefusedError(
                "markers",
                f"only {counted(common, 'marker')} of sphere {sphere} in common with "
                f"frame {frames[i - 1]}, {LEAST_COMMON} are needed",
                frames[i],
            )
        rotation.append(step @ rotation[-1])
    size = 1 + max((int(n.max()) for n in names if n.size), default=-1)
    every, match = sightings(front), np.concatenate(names)
    turns, used = np.array(rotation), np.ones(len(frames), dtype=np.bool_)
    pattern = average_pattern(every, turns, used, match, size)
    return Orientations(
        frames=front.frames,
        rotation=turns,
        covariance=orientation_covariances(every, turns, used, match, pattern),
        pattern=pattern,
        matches=tuple(match[own] for own in front.spans()),
        left_out={},
    )


def _step(
    before: Markers, names_before: NDArray[np.intp], now: Markers, names: NDArray[np.intp]
) -> Floats | None:
    common, first, second = np.intersect1d(names_before, names, return_indices=True)
    if common.size < LEAST_COMMON:
        return None
    weights = now.facing[second] ** 2
    return rotation_from_directions(before.directions[first], now.directions[second], weights)
