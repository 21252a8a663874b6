"""Visible share of a sphere's discs in a frame.

The direct image of a sphere that rises before the mirror hides the images in it. Where the two meet
one can be taken for the other, and a fit there is meaningless.
"""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import compiled
from analysis.photometric.follow.film import Film
from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.render.camera import Optics, discs_of
from analysis.photometric.render.residual import KEEP_OFF_PX

LEAST_OWN = 0.5
"""Of its direct image: with less a track ends."""
MET = "its direct image meets what the mirror shows, and its track ends"
POINTS = 97
GOLDEN = math.pi * (3.0 - math.sqrt(5.0))


@compiled
def own_shares(discs: Floats, sphere: int, shape: tuple[int, int]) -> tuple[float, float]:
    """Return how much of a sphere's direct image lies in the frame, and is no mirror's either.

    Parameters
    ----------
    discs
        Row, column and radius of all discs of a frame, those of sphere a first, the front view
        before the others, shape (2 V, 3).
    shape
        Rows and columns of the frame.

    Returns
    -------
    Shares of the disc within the frame, and of it within the frame and clear of what mirrors show
    of both spheres.
    """
    views = discs.shape[0] // 2
    own, inside, free = views * sphere, 0, 0
    for n in range(POINTS):
        # Points of a sunflower: even over the disc.
        far, angle = math.sqrt((n + 0.5) / POINTS) * discs[own, 2], n * GOLDEN
        row = discs[own, 0] + far * math.sin(angle)
        column = discs[own, 1] + far * math.cos(angle)
        if not (-0.5 <= row <= shape[0] - 0.5 and -0.5 <= column <= shape[1] - 0.5):
            continue
        inside += 1
        clear = True
        for disc in range(discs.shape[0]):
            if disc % views:
                reach = discs[disc, 2] + KEEP_OFF_PX
                away = (row - discs[disc, 0]) ** 2 + (column - discs[disc, 1]) ** 2
                clear = clear and away >= reach * reach
        free += clear
    return inside / POINTS, free / POINTS


def drop_unseen(film: Film, optics: Optics, radii_m: Floats) -> None:
    """End the tracks where less than half of a sphere's direct image is seen as such.

    Where it leaves the frame, and where it meets what the mirror shows; nothing is picked up again
    beyond.
    """
    discs = discs_of(optics, film.centre, radii_m, film.placed)
    for i, placed in enumerate(film.placed):
        frames = np.flatnonzero(placed)
        shares = np.array([own_shares(discs[k], i, _shape(film)) for k in frames]).reshape(-1, 2)
        lost = np.flatnonzero(shares[:, 1] < LEAST_OWN)
        if not len(lost):
            continue
        sound = np.flatnonzero(shares[:, 1] >= LEAST_OWN)
        middle = sound[len(sound) // 2] if len(sound) else 0
        first = lost[lost < middle].max(initial=-1) + 1
        last = lost[lost >= middle].min(initial=len(frames)) - 1
        beyond = np.concatenate([frames[:first], frames[last + 1 :]])
        met = np.isin(beyond, frames[shares[:, 0] >= LEAST_OWN])
        film.placed[i, beyond] = False
        film.leave_out(i, beyond[met], MET)


def seen_as_own(film: Film, known: Appearance, sphere: int, frame: int) -> bool:
    """Whether enough of a sphere's direct image is visible in a frame (`drop_unseen`)."""
    discs = film.discs(known, slice(frame, frame + 1))[0]
    inside, free = own_shares(discs, sphere, _shape(film))
    if free < LEAST_OWN <= inside:
        film.leave_out(sphere, np.array([frame]), MET)
    return free >= LEAST_OWN


def _shape(film: Film) -> tuple[int, int]:
    return film.frames.shape[1], film.frames.shape[2]
