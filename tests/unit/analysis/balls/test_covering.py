"""A ball covers its ground: nets, letters and shadows do not."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.balls.discs.disc import Disc
from analysis.balls.discs.evidence import Evidence, evidence
from analysis.balls.discs.finding import find_balls
from analysis.balls.discs.gradient import SIGMA_PX

CLOTH, RED = (150.0, 170.0, 140.0), (30.0, 20.0, 230.0)
ROW, COLUMN, RADIUS = 100.0, 150.0, 24.0
SPOKES, WIDTH, FELLY = 8, 3.0, 21.5


def taken(shown: Singles) -> Singles:
    blurred = cv2.GaussianBlur(shown, (0, 0), 0.8)
    noise = np.random.default_rng(1).normal(0, 1, shown.shape)
    return (blurred + noise).astype(np.float32)


def ball_on(other: tuple[float, ...]) -> Singles:
    shown = np.tile(np.array(CLOTH, np.float32), (200, 300, 1))
    cv2.circle(shown, (168, 114), 22, other, -1, cv2.LINE_AA)
    cv2.circle(shown, (150, 100), 22, RED, -1, cv2.LINE_AA)
    return taken(shown)


def spokes(rows: Floats, columns: Floats, half: float) -> NDArray[np.bool_]:
    """Return what is nearer than `half` to a spoke, of places about the middle."""
    turns = np.arange(SPOKES) * 2.0 * math.pi / SPOKES
    aside = [np.abs(rows * math.cos(turn) - columns * math.sin(turn)) for turn in turns]
    return np.asarray(np.min(aside, axis=0) < half)


def wheel(filled: bool) -> Singles:
    """Return a disc, or a rim with spokes and the ground between them."""
    fine = 4
    rows, columns = (np.mgrid[: 200 * fine, : 300 * fine] + 0.5) / fine - 0.5
    rows, columns = rows - ROW, columns - COLUMN
    away = np.hypot(rows, columns)
    dark = (away < RADIUS) & (filled | (away > FELLY) | spokes(rows, columns, 0.5 * WIDTH))
    shown = np.where(dark, 20.0, 240.0).reshape(200, fine, 300, fine).mean(axis=(1, 3))
    return taken(shown)[:, :, None]


def seen(picture: Singles) -> Evidence:
    found = evidence(picture, Disc(ROW, COLUMN, RADIUS, 0.1, 0.1, 0.1, 1.0, -60.0), SIGMA_PX, [])
    assert found is not None
    return found


def test_the_shadow_of_a_ball_is_no_ball() -> None:
    (found,) = find_balls(ball_on(tuple(0.78 * value for value in CLOTH)), (6.0, 60.0))
    assert (found.row, found.column, found.radius) == pytest.approx((100.0, 150.0, 22.0), abs=0.3)


def test_a_ball_of_another_colour_behind_a_ball_is_one() -> None:
    assert len(find_balls(ball_on((200.0, 60.0, 60.0)), (6.0, 60.0))) == 2


def test_in_a_single_channel_a_dark_ball_behind_a_bright_one_is_no_shadow() -> None:
    grey = ball_on(tuple(0.78 * value for value in CLOTH)).mean(axis=2)
    assert len(find_balls(grey, (6.0, 60.0))) == 2


def test_what_is_seen_of_the_ground_within_a_wheel_is_the_area_between_its_spokes() -> None:
    # Within 0.85 radii; next to a spoke and to the felly a pixel or so is of neither colour.
    rows, columns = np.mgrid[-30:31:0.25, -30:31:0.25]
    away, inner = np.hypot(rows, columns), 0.85 * RADIUS
    free = (away < min(inner, FELLY - 1.0)) & ~spokes(rows, columns, 0.5 * WIDTH + 1.0)
    share = free.sum() / (away < inner).sum()
    assert math.exp(seen(wheel(filled=False)).open) - 0.05 == pytest.approx(share, abs=0.05)
    assert math.exp(seen(wheel(filled=True)).open) - 0.05 == pytest.approx(0.0, abs=1e-6)


def test_the_edges_within_a_wheel_are_those_of_its_spokes() -> None:
    # Two to a spoke, but where spokes meet; a disc has none.
    most = 2.0 * SPOKES * 0.85 / (2.0 * math.pi)
    assert 0.5 * most < seen(wheel(filled=False)).busy < most
    assert seen(wheel(filled=True)).busy == 0.0


def test_a_wheel_is_less_likely_a_ball_than_a_disc_with_the_same_rim() -> None:
    assert seen(wheel(filled=False)).log_odds() < seen(wheel(filled=True)).log_odds() - 3.0
