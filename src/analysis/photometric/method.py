"""Frames of a shot to poses by rendering: learn the spheres once, then fit every frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from analysis.arrays import Floats, Grey, as_singles
from analysis.compiled import kept_on_disk
from analysis.errors import ShotRefusedError
from analysis.imaging.edge.frame import noise_sd
from analysis.photometric.follow.confirmation import shown_shares
from analysis.photometric.follow.film import (
    Film,
    cost_of,
    drop_misfits,
    round_smear,
    settle_film,
    settle_without_shadows,
)
from analysis.photometric.follow.first_tracking import first_tracking
from analysis.photometric.follow.following import Follower
from analysis.photometric.follow.start import LEAST_DARKNESS, first_film
from analysis.photometric.follow.votes import moving_part
from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.learn.learning import extended, learn, learn_together
from analysis.photometric.render.background import filled, first_background
from analysis.photometric.render.pose import fit_frames
from analysis.photometric.result import tracking_of
from analysis.photometric.slow_size import sized
from analysis.setup import Setup
from analysis.tracking import Tracking

LAST_LIMIT = 6.0
LEAST_PLACED = 6
POOR_COST, LEAST_GAIN, MORE_ROUNDS = 1.6, 0.95, 3
"""Cost of a frame (`film.cost_of`; 1.4 by noise alone) from which a film is learned from on, the
share of it that a round must leave at most for another, and the most rounds."""
COARSE = 2.0
"""`Appearance.coarseness` from which all these rounds are made."""
LONE_SCALE_SIGMA = 5e-4
"""Of the scale, for each unit of coarseness beyond 1, where one film alone taught."""
MOST_UNLIKE, SURE_SIGMAS = 0.02, 3.0
"""By how much learned radii may be off the ratio of the stated diameters, and errors of these: they
are off by 0.001 to 0.005, and by 0.03 to 0.08 where markers are taken for others (drawn spheres of
10 px radius)."""
SMEARED_ROUNDS = 3
"""Of learning once more from frames whose smear is taken out."""
LEAST_SHARE_OF_FILM = 0.88
"""Median over a film's frames: the learned spheres show 0.96 to 1.01, others 0.7 to 0.85."""
STANDARD_GRAVITY = 9.80665
NOISE_FRAMES = 3
"""Of the first guess of the noise."""


def compiles_first() -> bool:
    """Whether the next shot waits more than a minute for its functions to be compiled."""
    return not kept_on_disk(fit_frames)


def noise_of(frames: Grey) -> float:
    """Return a first guess of the noise of a pixel, grey levels."""
    return noise_sd(frames[:: max(1, len(frames) // NOISE_FRAMES)])


def learned_film(frames: Grey, times_s: Floats, setup: Setup) -> tuple[Film, Appearance]:
    """Learn how a pair looks from one shot; outlines and markers give the start.

    Raises
    ------
    ShotRefusedError
        With the step, the frame and the reason.
    """
    frames = as_singles(filled(frames, noise_of(frames)))
    start = first_tracking(frames, times_s, setup)
    film, guess = first_film(frames, times_s, start, setup)
    hold = setup.camera.scale_px_per_m is not None
    known = learn(film, guess, hold_scale=hold)
    film.set_motion(known, times_s, setup.camera.exposure_s)
    if film.motion.any():
        known = known.sharpened(round_smear(film, known))
        known = sharper([film], known, hold_scale=hold)
    refuse_faint(known)
    settle_film(film, known, LAST_LIMIT)
    known = _converged(film, known, hold_scale=hold)
    if not hold:
        lone = LONE_SCALE_SIGMA * (known.coarseness - 1.0)
        known = replace(known, scale_sigma=float(np.hypot(known.scale_sigma, lone)))
    refuse_unlike_sizes(known, setup)
    _finish(film, known)
    return film, known


def _converged(film: Film, known: Appearance, *, hold_scale: bool) -> Appearance:
    """Learn on from a film that is poorly explained, as long as that helps, and from small spheres.

    Markers of few pixels part from the shading slowly; the next shots would be followed by half of
    what this one shows. And the scale creeps toward the true one.
    """
    cost, coarse = _typical_cost(film), known.coarseness > COARSE
    for _ in range(MORE_ROUNDS):
        if cost < POOR_COST and not coarse:
            break
        known, before = learn_together([film], known, hold_scale=hold_scale), cost
        film.refresh(known)
        settle_film(film, known, LAST_LIMIT)
        cost = _typical_cost(film)
        if cost > LEAST_GAIN * before and not coarse:
            break
    return known


def _typical_cost(film: Film) -> float:
    """Return the larger of both spheres' median costs of a frame; 0 where none is placed."""
    costs = cost_of(film.quality, LAST_LIMIT)
    own = [costs[i, placed] for i, placed in enumerate(film.placed) if placed.any()]
    return max((float(np.median(each)) for each in own), default=0.0)


def sharper(films: Sequence[Film], known: Appearance, *, hold_scale: bool) -> Appearance:
    """Learn again with the known smear: the first appearance predicts the change by the smear."""
    for _ in range(SMEARED_ROUNDS if any(film.motion.any() for film in films) else 0):
        for film in films:
            settle_film(film, known, LAST_LIMIT)
            settle_without_shadows(film, known, LAST_LIMIT)
        known = learn_together(films, known, hold_scale=hold_scale)
    return known


def refuse_faint(known: Appearance) -> None:
    """Refuse spheres with markers too faint to determine orientation or radius.

    Raises
    ------
    ShotRefusedError
        With the sphere and what its markers swallow.
    """
    for name, sphere in zip("ab", known.spheres, strict=True):
        if sphere.darkness < LEAST_DARKNESS:
            found = f"what was taken for markers of sphere {name} swallows"
            share = f"{100 * sphere.darkness:.0f} % of the light, {100 * LEAST_DARKNESS:.0f} %"
            raise ShotRefusedError("markers", f"{found} {share} are needed to learn from")


def refuse_unlike_sizes(known: Appearance, setup: Setup) -> None:
    """Refuse spheres whose radii, as learned, are not in the ratio of the stated diameters.

    Markers that are taken for others in some frames fit none of them: they come out half as dark,
    and the sphere of the wrong size and off its place.

    Raises
    ------
    ShotRefusedError
        With the difference and the diameters.
    """
    a, b = (2.0 * sphere.radius_m for sphere in known.spheres)
    stated_a, stated_b = (sphere.diameter_m for sphere in setup.spheres)
    off = b / a * stated_a / stated_b - 1.0
    errors = [(each.diameter_sigma_m or 0.0) / each.diameter_m for each in setup.spheres]
    if abs(off) > math.hypot(MOST_UNLIKE, *(SURE_SIGMAS * each for each in errors)):
        raise ShotRefusedError(
            "markers",
            f"by markers sphere b is {100 * abs(off):.1f} % too {'large' if off > 0 else 'small'} "
            f"for diameters of {1e3 * stated_a:.4g} mm (a) and {1e3 * stated_b:.4g} mm (b): "
            "markers are taken for others, or a diameter is not as stated",
        )


def followed_film(
    frames: Grey,
    times_s: Floats,
    known: Appearance,
    exposure_s: float | None = None,
    gravity: float = STANDARD_GRAVITY,
) -> Film:
    """Measure the poses of a pair that is known.

    Parameters
    ----------
    exposure_s
        Time the shutter was open; None where it is not stated: then no smear is rendered.
    gravity
        m/s^2 along +X.

    Raises
    ------
    ShotRefusedError
        No frame shows the spheres as they are known.
    """
    noise = noise_of(frames)
    film = Film.blank(filled(frames, noise), len(known.camera.views), times_s, gravity)
    film.background, film.noise = first_background(film.frames), noise
    Follower(film, known.smeared()).run(times_s)
    film.set_motion(known, times_s, exposure_s)
    # Where no exposure is stated the blur stays as round as it was learned.
    drawn = known.smeared() if exposure_s is None else known
    film.refresh(drawn)
    settle_film(film, drawn, LAST_LIMIT)
    refuse_strangers(film, drawn)
    _finish(film, drawn)
    return film


def followed_pair(
    frames: Grey, times_s: Floats, setup: Setup, known: Appearance, *, extend: bool
) -> tuple[Film, Appearance]:
    """Measure the poses of a known pair, in the part of large pictures in which spheres move.

    Where that shows no pair the whole picture is looked at.

    Returns
    -------
    The film, maybe of that part alone, and the pair in pixels of the whole picture: `known` itself
    where the shot adds nothing.

    Raises
    ------
    ShotRefusedError
        As `followed_film` does.
    """
    part = moving_part(frames, known)
    if part is not None:
        shown = part.shown(known)
        try:
            film, more = _extended(part.of(frames), times_s, setup, shown, extend=extend)
        except ShotRefusedError:
            pass
        else:
            return film, known if more is shown else part.whole(more, known)
    return _extended(frames, times_s, setup, known, extend=extend)


def _extended(
    frames: Grey, times_s: Floats, setup: Setup, known: Appearance, *, extend: bool
) -> tuple[Film, Appearance]:
    """Return the poses of a known pair, and the pair, with what the shot adds where it may."""
    film = followed_film(frames, times_s, known, *circumstances(setup))
    if not extend or (more := extended(film, known)) is known:
        return film, known
    settle_film(film, more, LAST_LIMIT)
    _finish(film, more)
    return film, more


def circumstances(setup: Setup) -> tuple[float | None, float]:
    """Return the exposure, s, None where it is not stated, and gravity along +X, m/s^2."""
    return setup.camera.exposure_s, setup.environment.gravity_m_per_s2


def _finish(film: Film, known: Appearance) -> None:
    """Remove shadows and unreliable poses from a film that has converged."""
    settle_without_shadows(film, known, LAST_LIMIT)
    drop_misfits(film, known, LAST_LIMIT)
    refuse_few(film)


def refuse_strangers(film: Film, known: Appearance) -> None:
    """Refuse a film of other spheres than the known ones.

    A strange pattern can be turned so that most of its markers fall on dark places of each frame;
    over a whole film too little of them does.

    Raises
    ------
    ShotRefusedError
        With the sphere and what its markers show.
    """
    for i, name in enumerate("ab"):
        frames = np.flatnonzero(film.placed[i])
        shown = np.empty((len(frames), 2))
        shown_shares(film.reel(known, i), frames, shown)
        shares = shown[shown[:, 1] > 0, 0]
        middle = float(np.median(shares)) if len(shares) else 1.0
        if middle < LEAST_SHARE_OF_FILM:
            raise ShotRefusedError(
                "assignment",
                f"sphere {name} is not the one that was learned: its markers' places show "
                f"{middle:.2f} of their darkness, {LEAST_SHARE_OF_FILM:g} are needed",
            )


def refuse_few(film: Film) -> None:
    """Refuse a film with too few reliable frames of a sphere.

    Raises
    ------
    ShotRefusedError
        With the sphere and the number.
    """
    for name, placed in zip("ab", film.placed, strict=True):
        if placed.sum() < LEAST_PLACED:
            raise ShotRefusedError(
                "assignment",
                f"sphere {name} looks as it was learned in {int(placed.sum())} frames, "
                f"{LEAST_PLACED} are needed",
            )


def measure_poses(
    frames: Grey,
    times_s: Floats,
    setup: Setup,
    known: Appearance | None,
    *,
    extend: bool = False,
    unlike: str = "",
) -> tuple[Tracking, Appearance]:
    """Measure the poses of a pair: as it is known, or learned from this shot where it is not.

    Parameters
    ----------
    extend
        Let the shot add markers to what is known: those on a side that none has shown before.
    unlike
        Why the shot is learned by itself although others are known.

    Returns
    -------
    The poses, and what serves the next shot: `known` itself, where this one adds nothing.

    Raises
    ------
    ShotRefusedError
        With the step, the frame and the reason.
    """
    found = None
    if known is not None:
        # Other spheres, or another place of the camera: the shot is learned by itself.
        try:
            found = followed_pair(frames, times_s, setup, known, extend=extend)
        except ShotRefusedError as refusal:
            unlike = refusal.reason
    if found is None:
        film, known = learned_film(frames, times_s, setup)
        known = sized([film], known)
    else:
        film, known = found
    tracking = tracking_of(film, known, times_s, setup.environment.gravity_m_per_s2)
    if unlike:
        alone = f"learned by itself, with body axes and a scale of its own: {unlike}"
        tracking = replace(tracking, notes=(alone, *tracking.notes), learned_alone=True)
    return tracking, known
