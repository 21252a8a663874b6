"""Films as people take them: hands, fields, frames twice, balls that leave or roll away."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from tests.unit.cli.falling_ball import FALL, RADIUS, RATE, SHAPE, Drawn, bouncing, picture

PLATE = 200.0
FARTHEST = 17
"""Pixels from a ball's place that its window reaches: only there its parts are drawn."""


def interlaced(odd_first: bool) -> list[Drawn]:
    """Draw two times into each picture, in alternate rows."""
    fields = [picture(row, 45.0 + 0.3 * k) for k, row in enumerate(bouncing())]
    pictures = []
    for first, second in zip(fields[::2], fields[1::2], strict=True):
        both = first.copy()
        own = 0 if odd_first else 1
        both[own::2] = second[own::2]
        pictures.append(both)
    return pictures


def hand_over(shown: Drawn, row: float, column: float) -> Drawn:
    """Draw a hand of three fingers with round tips that reaches down to a place."""
    found = shown.copy()
    for finger in (-1, 0, 1):
        tip = (round(16 * (column + 11 * finger)), round(16 * (row - 4 * abs(finger))))
        top = (round(16 * (column + 16 * finger + 8)), round(16 * (row - 90)))
        cv2.line(found, top, tip, 135, 11, cv2.LINE_AA, 4)
    return np.asarray(found, np.uint8)


def released() -> tuple[list[Drawn], int]:
    """Draw a hand that holds a ball, lets it go and stays; return the frame of release too."""
    held = 30
    shown = []
    for k in range(held):
        sway = 1.5 * np.sin(k / 4.0)
        shown.append(hand_over(picture(40.0 + sway, 60.0), 32.0 + sway, 60.0))
    for k, row in enumerate(bouncing()):
        sway = 4.0 * np.sin(k / 9.0)
        shown.append(hand_over(picture(row), 24.0 - 0.15 * k + sway, 60.0 - 0.2 * k))
    return shown, held


def skipped_by_a_codec() -> tuple[list[Drawn], int]:
    """Draw 50 frames/s in which a codec skips a ball that is held, and at the top of its flight.

    Returns
    -------
    The pictures, and the first in which the ball has fallen.
    """
    held, top = 13, 31
    shown = [picture(40.0 + 0.003 * (k % 2)) for k in range(9)]
    shown += [shown[-1]] * (held - len(shown))
    flies = [picture(row) for row in bouncing(200)[4::4]]
    flies[top - 1] = flies[top - 2]
    return [*shown, *flies], held


def hand_beside() -> list[Drawn]:
    """Draw a hand that waves beside a ball that bounces."""
    return [
        hand_over(picture(row, 85.0), 120.0 + 25.0 * np.sin(k / 11.0), 25.0)
        for k, row in enumerate(bouncing())
    ]


def leaves_on_a_side() -> tuple[list[Drawn], int]:
    """Draw a ball that goes out of the picture on the right; return the first frame without it."""
    columns = [40.0 + 1.4 * k for k in range(100)]
    shown = [picture(row, column) for row, column in zip(bouncing(), columns, strict=True)]
    return shown, next(k for k, c in enumerate(columns) if c > SHAPE[1] + RADIUS)


def leaves_and_comes_back() -> list[Drawn]:
    """Draw a ball that enters at the top, bounces, and is above the picture in between."""
    speed, e, begun, last = 600.0, 0.9, 0.0, 0.0
    rows: list[float] = []
    contact = (np.sqrt(speed**2 + 2 * FALL * (PLATE + 20)) - speed) / FALL
    arrives = speed + FALL * contact
    for t in np.arange(300) / RATE:
        while t > contact:
            last, begun = e * arrives, contact
            contact, arrives = contact + 2 * last / FALL, last
        gone = t - begun
        start = (-20.0 + speed * gone) if last == 0.0 else (PLATE - last * gone)
        rows.append(start + 0.5 * FALL * gone**2)
    return [picture(row) for row in rows]


def wall_before_the_ball(light: float, frames: int) -> list[Drawn]:
    """Draw a light of the ball's size on the wall in some first frames; a ball enters in the 8th.

    Parameters
    ----------
    light
        Of the ball's light over that of the wall.
    """
    shown = [picture(-100.0)] * 8 + leaves_and_comes_back()[:120]
    spot = light * (picture(60.0, 100.0).astype(float) - picture(-100.0))
    return [
        np.asarray(np.clip(each + spot * (k < frames), 0, 255), np.uint8)
        for k, each in enumerate(shown)
    ]


def rolls_away() -> tuple[list[Drawn], int]:
    """Draw a ball that bounces and then rolls; return the frame in which it begins to roll."""
    rows = bouncing(140, 0.6)
    first = 110
    places = [(row, 60.0) for row in rows[:first]]
    places += [(PLATE, 60.0 + 0.6 * k) for k in range(60)]
    return [picture(row, column) for row, column in places], first


def frames_twice(*, off_px: float = 0.0) -> tuple[list[Drawn], list[int]]:
    """Draw a film in which every ninth picture is the one before it once more.

    Parameters
    ----------
    off_px
        By which a codec has moved the ball in the second one.
    """
    rows = bouncing()
    shown = [picture(row) for row in rows]
    twice = list(range(9, 100, 9))
    for k in twice:
        shown[k] = picture(rows[k - 1] + off_px) if off_px else shown[k - 1]
    return shown, twice


def brought_to_rate(pictures: int, frames: int, *, off_px: float = 0.0) -> list[Drawn]:
    """Draw a film of which each so many frames show so many pictures, which are evenly spaced.

    Parameters
    ----------
    off_px
        By which a codec has moved the ball in a picture that is shown once more.
    """
    rows = bouncing()
    which = [k * pictures // frames for k in range(len(rows) * frames // pictures)]
    again = [k > 0 and which[k] == which[k - 1] for k in range(len(which))]
    return [picture(rows[n] + off_px * twice) for n, twice in zip(which, again, strict=True)]


def frames_missing(first: int, count: int) -> list[Drawn]:
    """Draw a film without some of its frames."""
    shown = [picture(row) for row in bouncing(150)]
    return shown[:first] + shown[first + count :]


def rate_varies(
    changes: Callable[[NDArray[np.float64]], NDArray[np.float64]], count: int = 110
) -> list[Drawn]:
    """Draw a film whose frames are not evenly spaced in time.

    Parameters
    ----------
    changes
        Times of frames in s from those of even frames.
    """
    fine = 50
    rows = np.array(bouncing(fine * 2 * count, per_frame=fine))
    times = changes(np.arange(count) / RATE)
    return [picture(rows[round(fine * RATE * t)]) for t in times.tolist()]


def turning(sway: tuple[float, float] = (0.0, 0.0), count: int = 60) -> list[Drawn]:
    """Draw a ball at (100, 60) with sharp dark blotches that turns before a striped wall.

    In the second half of the frames it lies elsewhere by `sway`.
    """
    fine = 4
    wall_rows, wall_columns = _fine_grid((0, SHAPE[0]), (0, SHAPE[1]), fine)
    wall = _coarse(60.0 + 15.0 * np.sin(wall_rows / 3.0 + wall_columns / 5.0), fine)
    (top, bottom), (left, right) = ((at - FARTHEST, at + FARTHEST) for at in (100, 60))
    rows, columns = _fine_grid((top, bottom), (left, right), fine)
    behind = 60.0 + 15.0 * np.sin(rows / 3.0 + columns / 5.0)
    rng = np.random.default_rng(3)
    blotches = rng.normal(size=(9, 3))
    blotches /= np.linalg.norm(blotches, axis=1)[:, None]
    shown = []
    for k in range(count):
        share = float(2 * k >= count)
        down = (rows - 100.0 - share * sway[0]) / RADIUS
        across = (columns - 60.0 - share * sway[1]) / RADIUS
        toward = np.sqrt(np.maximum(1.0 - down**2 - across**2, 0.0))
        c, s = np.cos(0.1 * k), np.sin(0.1 * k)
        own = np.stack([down, c * across + s * toward, c * toward - s * across])
        dark = np.max(np.tensordot(blotches, own, 1), axis=0) > np.cos(0.35)
        inside = np.hypot(down, across) < 1.0
        small = wall.copy()
        small[top:bottom, left:right] = _coarse(
            np.where(inside, np.where(dark, 90.0, 200.0), behind), fine
        )
        blurred = np.asarray(cv2.GaussianBlur(small, (0, 0), 0.7), np.float64)
        noisy = blurred + rng.normal(0.0, 1.5, SHAPE)
        shown.append(np.asarray(np.clip(noisy, 0, 255), np.uint8))
    return shown


def _fine_grid(
    rows: tuple[int, int], columns: tuple[int, int], fine: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return rows and columns of parts of the pixels of a window."""
    (top, bottom), (left, right) = rows, columns
    down, across = np.mgrid[top * fine : bottom * fine, left * fine : right * fine]
    return (down + 0.5) / fine - 0.5, (across + 0.5) / fine - 0.5


def _coarse(grey: NDArray[np.float64], fine: int) -> NDArray[np.float64]:
    """Return the mean of the parts of each pixel."""
    rows, columns = grey.shape[0] // fine, grey.shape[1] // fine
    return np.asarray(grey.reshape(rows, fine, columns, fine).mean(axis=(1, 3)))


def turning_in_the_picture(count: int = 60) -> list[Drawn]:
    """Draw a ball at (100, 60) with one dark spot halfway to its rim that goes about its middle."""
    spots = []
    for k in range(count):
        turn = 0.12 * k
        own = picture(100.0, 60.0).copy()
        spot = (round(16 * (60.0 + 6.5 * np.cos(turn))), round(16 * (100.0 + 6.5 * np.sin(turn))))
        cv2.circle(own, spot, 16 * 3, 90, -1, cv2.LINE_AA, 4)
        spots.append(own)
    return spots


def in_a_holder(shown: list[Drawn]) -> list[Drawn]:
    """Put a holder over the lower part of a ball at (100, 60), and edges that flicker far from it.

    Codecs make edges flicker that stand still.
    """
    rng = np.random.default_rng(4)
    held = []
    for each in shown:
        own = each.copy()
        own[108:, 48:72] = 30
        for edge in (own[4:24:2, 2:4], own[204:224:2, 112:114]):
            edge[:] = np.where(rng.random(edge.shape) < 0.4, 150, 90)
        held.append(own)
    return held


def lit_from_above(rows: list[float], column: float = 60.0) -> list[Drawn]:
    """Draw a ball whose light fades to that of the wall at its lower side: its rim ends before."""
    fine = 5
    left, right = round(column) - FARTHEST, round(column) + FARTHEST
    rng = np.random.default_rng(11)
    shown = []
    for row in rows:
        top, bottom = max(0, round(row) - FARTHEST), min(SHAPE[0], round(row) + FARTHEST)
        down, across = _fine_grid((top, bottom), (left, right), fine)
        height = (row - down) / RADIUS
        light = 60.0 + 140.0 * np.clip(0.5 + height, 0.0, 1.0)
        grey = np.where(np.hypot(height, (across - column) / RADIUS) < 1.0, light, 60.0)
        small = np.full(SHAPE, 60.0)
        small[top:bottom, left:right] = _coarse(grey, fine)
        blurred = np.asarray(cv2.GaussianBlur(small, (0, 0), 0.7), np.float64)
        noisy = blurred + rng.normal(0.0, 1.5, SHAPE)
        shown.append(np.asarray(np.clip(np.rint(noisy), 0, 255), np.uint8))
    return shown


def two_that_fall_otherwise() -> list[Drawn]:
    """Draw two balls of one size, the second farther from the camera's scale: it falls slower.

    The first, whose size is stated, is seen in fewer frames.
    """
    slow = bouncing(400, 0.7, per_frame=4)
    times = np.arange(100) / RATE
    others = np.interp(0.75 * times, np.arange(400) / (4 * RATE), slow)
    return [
        np.hstack([picture(row if k >= 12 else -100.0), picture(float(other))])
        for k, (row, other) in enumerate(zip(bouncing(), others, strict=True))
    ]


def upside_down_after_a_fall() -> list[Drawn]:
    """Draw a ball that bounces in pictures upside down, and before it one that falls upright."""
    falls = [picture(40.0 + 0.5 * FALL * (k / RATE) ** 2, 30.0) for k in range(45)]
    return falls + [np.ascontiguousarray(picture(row)[::-1, ::-1]) for row in bouncing()]


def noise_alone(sigma: float, count: int = 24) -> list[Drawn]:
    """Draw pictures of a wall."""
    rng = np.random.default_rng(5)
    return [
        np.asarray(np.clip(np.rint(rng.normal(90.0, sigma, SHAPE)), 0, 255), np.uint8)
        for _ in range(count)
    ]
