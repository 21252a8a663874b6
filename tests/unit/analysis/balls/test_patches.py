"""Places and radius of a drawn ball with dark patches, which a smooth shading takes for ground."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.balls.seen.looks import patched_weights
from analysis.balls.seen.placing import Placer
from analysis.balls.seen.windows import Motion, Window

Floats = NDArray[np.float64]

RADIUS, SIDE, FINE = 16.0, 64, 5
GROUND, WHITE, BLACK = 1.0, 3.0, 0.12
PATCH = np.cos(0.36)
CENTRE = np.array([31.3, 32.4])
TURNS = (0.0, 0.7, 1.9, 3.1, 4.4)


def drawn(turn: float, shadow: float = 0.0) -> Window:
    """Draw a lit football by counting fine pixels; a soft shadow of that depth lies below it."""
    rows, columns = (np.mgrid[: SIDE * FINE, : SIDE * FINE] + 0.5) / FINE - 0.5
    v, u = (rows - CENTRE[0]) / RADIUS, (columns - CENTRE[1]) / RADIUS
    towards = np.sqrt(np.maximum(0.0, 1.0 - u * u - v * v))
    # Turned about an axis that leans to the side.
    across, ahead = np.cos(turn) * u + np.sin(turn) * towards, np.cos(turn) * towards
    ahead = ahead - np.sin(turn) * u
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    corners = [(0.0, a, b * golden) for a in (-1, 1) for b in (-1, 1)]
    corners += [(c, a, b) for a, b, c in corners] + [(b, c, a) for a, b, c in corners]
    nearest = np.max([across * a + v * b + ahead * c for a, b, c in corners], axis=0)
    black = nearest > PATCH * np.hypot(1.0, golden)
    light = np.where(black, BLACK, WHITE) * (0.55 + 0.3 * towards - 0.15 * v)
    under = shadow * np.exp(
        -((rows - CENTRE[0] - 1.2 * RADIUS) ** 2 + 0.3 * (u * RADIUS) ** 2) / 60
    )
    seen = np.where(np.hypot(u, v) < 1.0, light, GROUND * (1.0 - under))
    whole = seen.reshape(SIDE, FINE, SIDE, FINE).mean(axis=(1, 3))
    whole = whole + np.random.default_rng(round(10 * turn)).normal(0.0, 0.02, whole.shape)
    ground = np.full(whole.shape, GROUND)
    layers = np.stack([whole, ground, np.ones_like(ground), np.zeros_like(ground)])
    return Window(round(10 * turn), 0, 0, layers)


def placer_of(radius: float, *, patched: bool = True) -> Placer:
    placer = Placer.new(radius, 0.0, patched=patched)
    placer.blur_px = 0.6
    return placer


def motion_of(windows: list[Window]) -> Motion:
    """Expect the ball a pixel and a half from where it is."""
    frames = np.array([window.frame for window in windows])
    places = np.tile(CENTRE + np.array([1.2, -0.9]), (len(windows), 1))
    return Motion(frames, places, np.zeros((len(windows), 2)))


def off(turn: float, *, patched: bool = True, shadow: float = 0.0) -> float:
    """Return how far from its centre the ball is placed, px."""
    windows = [drawn(turn, shadow)]
    placed = placer_of(RADIUS, patched=patched).place(windows, motion_of(windows))
    return float(np.hypot(*(placed.places[0] - CENTRE)))


@pytest.mark.parametrize("turn", TURNS)
def test_a_dark_patch_at_the_rim_moves_no_ball(turn: float) -> None:
    assert off(turn) < 0.02 * RADIUS


def test_a_smooth_shading_takes_patches_for_the_ground() -> None:
    assert max(off(turn, patched=False) for turn in TURNS) > 0.08 * RADIUS


@pytest.mark.parametrize("turn", TURNS)
def test_a_shadow_below_it_moves_no_ball_with_patches(turn: float) -> None:
    assert off(turn, shadow=0.6) < 0.04 * RADIUS


@pytest.mark.parametrize("found", [0.92, 1.0, 1.08])
def test_the_outline_tells_the_radius_that_edges_of_patches_do_not(found: float) -> None:
    windows = [drawn(turn) for turn in np.linspace(0.0, 6.0, 12).tolist()]
    placer = placer_of(found * RADIUS)
    placer.learn_radius(windows, motion_of(windows))
    assert placer.radius_px == pytest.approx(RADIUS, rel=0.03)


def test_a_ball_with_patches_teaches_no_light() -> None:
    windows = [drawn(turn) for turn in TURNS]
    placer = placer_of(RADIUS)
    placer.learn_light(windows, motion_of(windows))
    assert not placer.table.any()


def test_a_ball_with_patches_is_measured_by_its_brightness() -> None:
    # As bright as its ground in the mean, and far from it everywhere.
    still = np.full((400, 3), 0.5, np.float32)
    ball = np.repeat([[0.05], [0.95]], 200, axis=0).astype(np.float32) * np.ones((1, 3), np.float32)
    weights = patched_weights(ball, still)
    assert (weights > 0.0).all()
    assert np.sqrt((((ball - still) @ weights) ** 2).mean()) == pytest.approx(1.0)
