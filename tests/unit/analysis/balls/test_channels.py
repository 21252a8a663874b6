"""Of a ball's channels the one is taken in which its places lie nearest to free flights."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.balls.clearest import Channel, clearest
from analysis.balls.discs.disc import Disc
from analysis.balls.films.film import Film, FilmHead, Picture
from analysis.balls.flight.flights import Start
from analysis.balls.flight.known import Ball, Known, View
from analysis.balls.seen.channels import other_weights
from analysis.balls.seen.looks import Looks, shaded
from analysis.balls.seen.placing import Placer
from analysis.balls.seen.windows import Cuts, Motion
from analysis.balls.settling import observed_of

Floats = NDArray[np.float64]

RADIUS, ROWS, COLUMNS = 9.0, 180, 150
RATE_HZ, PER_M = 60.0, 450.0
GROUND, LIGHT = 60.0, 180.0
PLATE, TOP, E = 150.0, 40.0, 0.8
SPOILED, SOUND = np.array([1.0, 0.0, 0.0]) / 120.0, np.array([0.0, 1.0, 0.0]) / 120.0


class ColourFilm(Film):
    """Colour frames in memory, shape (frames, rows, columns, 3)."""

    def __init__(self, frames: NDArray[np.uint8]) -> None:
        super().__init__(Path("film"), FilmHead(*frames.shape))
        self._frames = frames

    def _read(self) -> Iterator[Picture]:
        yield from self._frames


def flown() -> tuple[Floats, Floats, float]:
    """Return times and places of a ball that is dropped and bounces once, and when it does."""
    fall = 9.80665 * PER_M
    contact = float(np.sqrt(2.0 * (PLATE - TOP) / fall))
    away = E * fall * contact
    times = np.arange(int((contact + 2.0 * away / fall) * RATE_HZ)) / RATE_HZ
    since = np.maximum(0.0, times - contact)
    rows = np.where(times < contact, TOP + 0.5 * fall * times**2, PLATE - away * since)
    rows = rows + 0.5 * fall * since**2
    return times, np.stack([rows, 40.0 + 90.0 * times], axis=1), contact


def a_film(places: Floats) -> ColourFilm:
    """Draw a ball whose first colour a codec has moved by up to two pixels, each time anew."""
    rng = np.random.default_rng(4)
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    frames = np.empty((len(places), ROWS, COLUMNS, 3))
    for frame, (row, column) in zip(frames, places, strict=True):
        for colour in range(3):
            down, across = rng.uniform(-2.0, 2.0, 2) if colour == 0 else (0.0, 0.0)
            away = np.hypot(rows - row - down, columns - column - across)
            share = np.clip(RADIUS - away + 0.5, 0.0, 1.0)
            frame[..., colour] = GROUND + share * (LIGHT - GROUND)
    noisy = frames + rng.normal(0.0, 1.5, frames.shape)
    return ColourFilm(np.rint(noisy).astype(np.uint8))


def chosen(own: Floats, others: tuple[Floats, ...]) -> tuple[Channel, Floats]:
    """Return the channel that is taken, and the true places of its frames."""
    times, places, contact = flown()
    film, speeds = a_film(places), np.gradient(places, times, axis=0)
    motion = Motion(np.arange(len(times)), places, speeds)
    seen: tuple[tuple[int, Disc], ...] = ()
    looks = Looks(
        RADIUS,
        0.05,
        np.ones((6, 3)),
        np.eye(3),
        own,
        seen,
        others=others,
    )
    cuts, placer = Cuts(film, looks, motion, 0.0), Placer.new(RADIUS, 0.0)
    windows = cuts.windows(looks)
    placer.learn_blur(windows, motion)
    first = Channel(looks, windows, placer.place(windows, motion))
    ball, view = Ball(2.0 * RADIUS / PER_M, density=1000.0), View(ROWS, COLUMNS, 1 / RATE_HZ, 0.0)
    speed = 9.80665 * PER_M * contact
    start = Start(
        np.array([contact]),
        np.array([[PLATE, 40.0 + 90.0 * contact]]),
        np.array([[speed, 90.0]]),
        np.array([[-E * speed, 90.0]]),
    )
    known = Known(ball, view, RADIUS, 0.05)
    fitting = (lambda placed: observed_of(placed, times, None)), start, known
    found = clearest(placer, first, (cuts, motion), fitting)
    return found, places[found.placed.frames]


def test_a_channel_that_a_codec_spoils_is_left_for_one_that_lies_on_the_flights() -> None:
    found, true = chosen(SPOILED, (SOUND,))
    off = found.placed.places - true
    # Frames in contact are drawn as points of flights, too.
    assert np.sqrt((off**2).mean()) < 0.2
    np.testing.assert_array_equal(found.looks.light_weights, SOUND)


def test_a_channel_that_lies_on_the_flights_is_kept() -> None:
    found, _ = chosen(SOUND, (SPOILED,))
    np.testing.assert_array_equal(found.looks.light_weights, SOUND)


def values_of(change: Floats, base: Floats, noise: Floats) -> tuple[Picture, Picture, Floats]:
    """Return pixels of a ball and of its ground, raw light, and the terms of its shading."""
    rng = np.random.default_rng(2)
    u, v = rng.uniform(-0.6, 0.6, (2, 500))
    still = np.tile(base, (500, 1))
    ball = still + change + rng.normal(0.0, noise, (500, 3))
    return np.rint(ball).astype(np.uint16), np.rint(still).astype(np.uint16), shaded(u, v)


LIGHT_HEAD = FilmHead(1, 4, 4, 3)
"""Of a film whose values are light."""


def test_no_other_channel_is_told_of_one_colour() -> None:
    values = np.full((9, 1), 9, np.uint8), np.full((9, 1), 2, np.uint8)
    assert other_weights(values, np.ones((9, 6)), FilmHead(1, 4, 4, 1), np.ones(1)) == ()


def test_a_ball_is_of_unit_height_in_each_channel_and_colours_that_vary_count_little() -> None:
    change, base = np.array([900.0, 900.0, 900.0]), np.array([50.0, 0.0, 0.0])
    ball, still, terms = values_of(change, base, np.array([0.0, 0.0, 300.0]))
    own = np.array([0.0, 0.0, 1.0 / 900.0])
    found = other_weights((ball, still), terms, LIGHT_HEAD, own)
    mean = ball.mean(axis=0) - still.mean(axis=0)
    for weights in found:
        np.testing.assert_allclose(weights @ mean, 1.0, atol=1e-9)
    coded, whole = found[:2]
    # All colours have a codec's error alike; what a shading leaves is in the last one.
    np.testing.assert_allclose(coded / coded[0], mean / mean[0], rtol=1e-6)
    assert abs(whole[2]) < 0.01 * abs(whole[1])


def test_a_shadow_of_the_ground_hardly_shows_in_a_channel_that_counts_it() -> None:
    change, base = np.array([100.0, 400.0, 800.0]), np.array([800.0, 800.0, 800.0])
    ball, still, terms = values_of(change, base, np.full(3, 5.0))
    own = np.array([1.0, 0.0, 0.0]) / 100.0
    coded, whole = other_weights((ball, still), terms, LIGHT_HEAD, own)[:2]
    dimmed = 0.3 * base
    assert abs(float(whole @ dimmed)) < 0.05
    assert abs(float(coded @ dimmed)) > 0.3
