"""A ball's places as they are fitted first, before a film has taught the ball's own light."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from analysis.arrays import Floats
from analysis.balls.clearest import Channel, clearest
from analysis.balls.films.film import Film, FilmHead
from analysis.balls.flight.flights import Start
from analysis.balls.flight.known import Ball, Known, View
from analysis.balls.found import Search
from analysis.balls.hands import free, let_go
from analysis.balls.seen.arcs import Chain
from analysis.balls.seen.looks import Looks
from analysis.balls.seen.placing import Placer
from analysis.balls.seen.windows import Cuts, Motion, Seen, Window
from analysis.balls.settling import observed_of

NEIGHBOURS = 5
"""Sightings before and after that tell a speed before any flight is fitted."""


def first_places(
    film: Film,
    found: Search,
    stated: tuple[Ball, float | None],
    flown: tuple[Start, Motion, float],
) -> tuple[Placer, tuple[float, float] | None, Channel]:
    """Return a ball's places before its light is learned, in the channel that shows them best.

    Parameters
    ----------
    flown
        A first guess of its bounces, where it is expected, and the time between frames.

    Returns
    -------
    What placed it, the exposure that was found with its error, and the channel.
    """
    (ball, exposure_s), (start, motion, period) = stated, flown
    looks, chain, times_s = found.looks, found.chain, found.times_s
    placer = Placer.new(looks.radius_px, exposure_s or 0.0, patched=looks.patched)
    longest = period if exposure_s is None else exposure_s
    seen = Seen(found.gains, found.about, found.unexplained)
    looks, windows, cuts = _windows(
        placer, looks, motion, lambda ball: Cuts(film, ball, motion, longest, seen)
    )
    told = None if exposure_s is not None else placer.learn_exposure(windows, motion, period)
    clear = free(placer.place(windows, motion), chain)
    placed = clear.of(let_go(clear.frames, clear.places[:, 0], (chain, times_s), looks.radius_px))
    view = view_of(film.head, period, placer.exposure_s)
    known = Known(ball, view, looks.radius_px, looks.radius_sigma_px)
    fitting = (lambda places: observed_of(places, times_s, None)), start, known
    own = Channel(looks, windows, placed)
    return placer, told, clearest(placer, own, (cuts, motion), fitting)


def first_motion(chain: Chain, fall: Floats) -> Motion:
    """Return places as they were seen, and speeds from the sightings about each."""
    frames, places, speeds = [], [], []
    for arc in chain.arcs:
        for k, frame in enumerate(arc.frames.tolist()):
            part = slice(max(0, k - NEIGHBOURS), k + NEIGHBOURS + 1)
            middle, _, speed = arc.course_of(part, fall)
            frames.append(frame)
            places.append(arc.places[k])
            speeds.append(speed + fall * (arc.times_s[k] - middle))
    order = np.argsort(frames, kind="stable")
    frames_, index = np.unique(np.array(frames)[order], return_index=True)
    return Motion(frames_, np.array(places)[order][index], np.array(speeds)[order][index])


def _windows(
    placer: Placer, looks: Looks, motion: Motion, cut: Callable[[Looks], Cuts]
) -> tuple[Looks, list[Window], Cuts]:
    """Return the ball's looks and windows, with the radius and the blur that explain them best."""
    cuts = cut(looks)
    windows = cuts.windows(looks)
    placer.learn_blur(windows, motion)
    if placer.learn_radius(windows, motion):
        looks = looks.with_radius(placer.radius_px)
        cuts = cut(looks)
        windows = cuts.windows(looks)
        placer.learn_blur(windows, motion)
    return looks, windows, cuts


def view_of(head: FilmHead, period_s: float, exposure_s: float) -> View:
    """Return what is known of how a film was taken."""
    return View(
        *head.whole,
        period_s,
        exposure_s,
        head.readout,
        focal_px=head.focal_px,
        principal_px=head.principal,
        compressed=head.compressed,
    )
