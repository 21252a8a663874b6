"""How a pair looks, from the first shots of a campaign together.

A shot that turns a side of a sphere to the camera of which hardly a marker is known yet may be
followed in a wrong turn, and what it shows beside that would be learned in wrong places. Free
spheres turn at one rate on either side of a contact; wrong turns do not, by ten to two hundred
times the squares of their errors. Such a shot waits until the others have taught.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis.arrays import Floats, Grey
from analysis.errors import ShotRefusedError
from analysis.imaging.stated_view import stated_view
from analysis.motion.drift import Drift
from analysis.motion.spin import fit_spin
from analysis.motion.split import split_at_contact
from analysis.photometric.follow.film import Film, drop_misfits, settle_film
from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.learn.learning import learn_together, without_false
from analysis.photometric.method import (
    LAST_LIMIT,
    circumstances,
    followed_film,
    learned_film,
    sharper,
)
from analysis.photometric.result import centres_of
from analysis.photometric.slow_size import sized
from analysis.setup import Setup

Taught = tuple[Grey, Floats, Setup]
"""Grey levels (frames, rows, columns) and times, s (frames,), of one shot, and its set-up."""

NO_DRIFT = Drift(0.0, 1.0)
LEAST_ON_A_SIDE = 4
MOST_PATTERN_SIGMA = 3e-3
"""Of a marker, rad, beyond which films show parts of a pattern that hardly hang together: 0.1 to
0.4 mrad otherwise, 1.6 of small spheres in one film. Each shot is better measured by itself."""
MOST_TURN_CHI2 = 6.0
"""Per degree of freedom, about one spin: true turns have 0.6 to 2.3, wrong ones 12 and more."""


def teach(shots: Sequence[Taught]) -> Appearance | None:
    """Learn how a pair looks from the first shots of a campaign, together.

    Parameters
    ----------
    shots
        With set-ups that differ by their exposures alone.

    Returns
    -------
    None where no shot can be learned from; measuring each shot then gives its reason.
    """
    views = [_in_view(shot) for shot in shots]
    hold = bool(shots) and shots[0][2].camera.scale_px_per_m is not None
    known: Appearance | None = None
    films: list[Film] = []
    waiting: list[Taught] = []
    for shot in views:
        if known is not None:
            film = _followed(shot, known)
        else:
            try:
                film, known = learned_film(*shot)
            except ShotRefusedError:
                continue
            if len(shots) > 1:
                known = without_false([film], known, unseen=False)
        if film is None:
            waiting.append(shot)
        else:
            films.append(film)
    if known is None:
        return None
    alone = known
    known = _together(films, known, hold_scale=hold)
    late = [film for shot in waiting if (film := _followed(shot, known)) is not None]
    if late:
        films += late
        known = _together(films, known, hold_scale=hold)
    if len(films) > 1:
        known = sharper(films, known, hold_scale=hold)
    if known.pattern_sigma_rad > MOST_PATTERN_SIGMA:
        known, films = alone, films[:1]
    for film in films:
        settle_film(film, known, LAST_LIMIT)
        drop_misfits(film, known, LAST_LIMIT)
    return sized(films, known)


def _in_view(shot: Taught) -> Taught:
    frames, times_s, setup = shot
    frames, setup = stated_view(frames, setup)
    return frames, times_s, setup


def _together(films: Sequence[Film], known: Appearance, *, hold_scale: bool) -> Appearance:
    return learn_together(films, known, hold_scale=hold_scale) if len(films) > 1 else known


def _followed(shot: Taught, known: Appearance) -> Film | None:
    """Return the poses of a shot; None where its spheres do not look as known, or turn freely."""
    frames, times_s, setup = shot
    try:
        film = followed_film(frames, times_s, known, *circumstances(setup))
    except ShotRefusedError:
        return None
    return film if turns_freely(film, known) else None


def turns_freely(film: Film, known: Appearance) -> bool:
    """Whether each sphere turns at one rate before the contact and at one after it.

    True where no contact is found, and of a side with fewer frames than `LEAST_ON_A_SIDE`.
    """
    times_s = film.times_s
    try:
        places = centres_of(film, known, 0), centres_of(film, known, 1)
        split = split_at_contact(*places, times_s, film.gravity)
    except ShotRefusedError:
        return True
    every = np.arange(len(times_s))
    # The frames next to the contact may hold both motions.
    for side in (every < split - 1, every > split):
        for i in (0, 1):
            own = np.flatnonzero(side & film.placed[i])
            if len(own) < LEAST_ON_A_SIDE:
                continue
            turns: tuple[Floats, Floats] = film.rotation[i, own], film.covariance[i, own][:, 3:, 3:]
            if fit_spin(times_s[own], *turns, NO_DRIFT).chi2_per_dof > MOST_TURN_CHI2:
                return False
    return True
