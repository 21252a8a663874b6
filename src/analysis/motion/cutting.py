"""Tracks of two spheres cut where they tear, before any law is fitted."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.errors import ShotRefusedError
from analysis.motion.frame_notes import gathered
from analysis.motion.poses import Centres
from analysis.motion.tears import BEYOND, LESS_CERTAIN, OFF, UNCERTAIN, label_side

Frames = NDArray[np.intp]

AIR_SLOWS = 1e-3
"""Deceleration by the air over the square of the speed, times the diameter, at most: that of a
sphere half as dense as water (3/4 of its coefficient of drag and of the air's density over its
own)."""
NEAR, PRESSED = 1.3, 0.993
"""Distances of the centres, in that at touch: beyond the first no contact is, within the second
the spheres press each other, whatever the scale is off."""
IN_CONTACT = "the spheres are pressed together"
REASONS = {
    OFF: "it lies off the free flight of its track",
    UNCERTAIN: f"its errors are more than {LESS_CERTAIN:g} times those of its track",
    BEYOND: "it touches something else there, or its track is torn",
}


def cut_tears(
    centres: tuple[Centres, Centres], times_s: Floats, gravity: float, touch_m: float
) -> tuple[dict[int, str], dict[int, str]]:
    """Return which frames of each sphere belong to no free flight, and why.

    From the frame in which the spheres are first nearest each other each side is followed outward
    (`tears`): what they do at a second contact, with each other or with anything else, ends their
    tracks. None where they never come near, which another step refuses.

    Parameters
    ----------
    times_s
        Of all frames, shape (F,).
    gravity
        m/s^2 along +X.
    touch_m
        Distance of the centres at touch.
    """
    common, distance, whole = _distances(centres, touch_m)
    span = _contact(distance, whole & (distance < PRESSED))
    if span is None:
        return {}, {}
    pressed = {int(k): IN_CONTACT for k in common[slice(*span)]} if span[1] - span[0] > 1 else {}
    ends = int(common[span[0]]), int(common[span[1] - 1])
    slows = AIR_SLOWS / touch_m
    a, b = (_left_out(own, (times_s, gravity, slows), ends) for own in centres)
    return pressed | a, pressed | b


def refuse_jumps(
    centres: tuple[Centres, Centres],
    left_out: tuple[dict[int, str], dict[int, str]],
    touch_m: float,
) -> None:
    """Refuse tracks that both leave free flight at once while the spheres are apart.

    Frames are then lost, repeated or exchanged, and times are unreliable.

    Parameters
    ----------
    left_out
        As `cut_tears` returned them.

    Raises
    ------
    ShotRefusedError
        With the frame.
    """
    common, distance, whole = _distances(centres, touch_m)
    span = _contact(distance, whole & (distance < PRESSED))
    if span is None:
        return
    a, b = left_out
    ends = int(common[span[0]]), int(common[span[1] - 1])
    apart = set(common[distance > NEAR].tolist())
    for before in (True, False):
        of_a, of_b = (_nearest(own, ends, before=before) for own in (a, b))
        if of_a is not None and of_a == of_b and of_a in apart:
            raise ShotRefusedError(
                "motion",
                "both tracks leave free flight at once while the spheres are apart; look for "
                "lost, repeated or exchanged frames",
                of_a,
            )


def _nearest(left_out: dict[int, str], ends: tuple[int, int], *, before: bool) -> int | None:
    """Return the frame nearest the contact on one side of it that is left out."""
    if before:
        return max((k for k in left_out if k < ends[0]), default=None)
    return min((k for k in left_out if k > ends[1]), default=None)


def _distances(
    centres: tuple[Centres, Centres], touch_m: float
) -> tuple[Frames, Floats, NDArray[np.bool_]]:
    """Return the frames with both spheres, how far apart they are there, and where that is known.

    In `touch_m`: without the depth where one sphere hides that of the other in the mirror, and
    infinite where more than that is not measured.
    """
    common, of_a, of_b = np.intersect1d(
        centres[0].frames, centres[1].frames, assume_unique=True, return_indices=True
    )
    apart = centres[1].position[of_b] - centres[0].position[of_a]
    seen = np.isfinite(apart)
    distance = np.linalg.norm(np.where(seen, apart, 0.0), axis=1) / touch_m
    distance = np.where(seen[:, :2].all(axis=1), distance, np.inf)
    return common, np.asarray(distance), np.asarray(seen.all(axis=1))


def _contact(distance: Floats, pressed: NDArray[np.bool_]) -> tuple[int, int] | None:
    """Return the half-open range of the first frames that show a contact, at least the nearest."""
    padded = np.concatenate([[np.inf], distance, [np.inf]])
    lowest = (distance <= padded[:-2]) & (distance <= padded[2:]) & (distance < NEAR)
    if not lowest.any():
        return None
    first = last = int(lowest.argmax())
    while first > 0 and pressed[first - 1]:
        first -= 1
    while last + 1 < len(distance) and pressed[last + 1]:
        last += 1
    return first, last + 1


def _left_out(
    own: Centres, flying: tuple[Floats, float, float], contact: tuple[int, int]
) -> dict[int, str]:
    """Return the frames of one sphere that are no free flight outside a contact, and why.

    Parameters
    ----------
    flying
        Times of all frames, s, gravity, m/s^2, and by how much the air may slow it, 1/m.
    """
    times_s, gravity, slows = flying
    found: dict[int, str] = {}
    before = np.flatnonzero(own.frames < contact[0])[::-1]
    after = np.flatnonzero(own.frames > contact[1])
    for order, end in ((before, contact[0]), (after, contact[1])):
        frames = own.frames[order]
        tau = times_s[frames] - times_s[end]
        labels = label_side(
            tau, own.position[order], own.sigma[order], gravity=gravity, slows_per_m=slows
        )
        found |= {int(k): REASONS[int(n)] for k, n in zip(frames, labels, strict=True) if n}
    return found


def notes_of(name: str, left_out: Mapping[int, str]) -> tuple[str, ...]:
    """Return a sentence for each reason for which frames of a sphere are left out."""
    each = (f"frame {k} left out for sphere {name}: {why}" for k, why in sorted(left_out.items()))
    return tuple(gathered(tuple(each)))
