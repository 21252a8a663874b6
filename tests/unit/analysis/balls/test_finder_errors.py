"""Errors of found discs that are blotched or smeared, against drawings whose centres are known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.balls.discs.finding import find_balls
from analysis.balls.discs.rims import fit_rim
from tests.unit.analysis.drawings import coverage, grey

Floats = NDArray[np.float64]
SHAPE, RADIUS, GROUND, BALL = (110, 130), 22.0, 50.0, 190.0
AS_DARK = GROUND / BALL
DISCS = 24


def lit(row: float, column: float, rng: np.random.Generator, least_ambient: float = 0.35) -> Floats:
    """Return a ball's light, lit from one side: half of its rim may be as dark as the ground."""
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    down, across = (rows - row) / RADIUS, (columns - column) / RADIUS
    ahead = np.sqrt(np.maximum(1.0 - down**2 - across**2, 0.0))
    angle, aside = rng.uniform(0, 2 * np.pi), rng.uniform(0.3, 0.8)
    facing = aside * (down * np.sin(angle) + across * np.cos(angle))
    facing += np.sqrt(1 - aside**2) * ahead
    ambient = rng.uniform(least_ambient, 0.6)
    return np.asarray(BALL * (ambient + (1.0 - ambient) * np.maximum(facing, 0.0)))


def blotched(row: float, column: float, rng: np.random.Generator) -> Floats:
    """Draw a ball with dark blotches, some of which cross its rim."""
    light = lit(row, column, rng)
    for _ in range(9):
        angle, away = rng.uniform(0, 2 * np.pi), RADIUS * rng.uniform(0.2, 1.0)
        place = (row + away * np.sin(angle), column + away * np.cos(angle), rng.uniform(2.0, 5.0))
        light *= 1.0 - rng.uniform(0.2, 0.6) * coverage(place, SHAPE)
    return np.asarray(GROUND + (light - GROUND) * coverage((row, column, RADIUS), SHAPE))


def smeared(row: float, column: float, rng: np.random.Generator) -> Floats:
    """Draw a ball that moves by up to half a radius while the shutter is open."""
    angle, way = rng.uniform(0, 2 * np.pi), RADIUS * rng.uniform(0.1, 0.5)
    seed = int(rng.integers(1000))
    shown = np.zeros(SHAPE)
    for step in (way * (np.arange(12) + 0.5) / 12 - 0.5 * way).tolist():
        place = (row + step * np.sin(angle), column + step * np.cos(angle))
        light = lit(*place, np.random.default_rng(seed))
        shown += GROUND + (light - GROUND) * coverage((*place, RADIUS), SHAPE)
    return np.asarray(shown / 12)


def dark_sided(row: float, column: float, rng: np.random.Generator) -> Floats:
    """Draw a ball whose other side is hardly brighter than the ground, or not at all."""
    light = lit(row, column, rng, AS_DARK)
    return np.asarray(GROUND + (light - GROUND) * coverage((row, column, RADIUS), SHAPE))


def hidden(row: float, column: float, rng: np.random.Generator) -> Floats:
    """Draw a ball with hardly any shade, a third of which is behind a board."""
    light = lit(row, column, rng, 0.599)
    shown = np.asarray(GROUND + (light - GROUND) * coverage((row, column, RADIUS), SHAPE))
    shown[round(row + rng.uniform(0.1, 0.4) * RADIUS) :] = 110.0
    return shown


@pytest.mark.parametrize("draw", [blotched, smeared, dark_sided, hidden])
def test_errors_of_blotched_smeared_and_hidden_balls_are_as_large_as_they_are_off(
    draw: Callable[[float, float, np.random.Generator], Floats],
) -> None:
    rng = np.random.default_rng(11)
    pulls: list[float] = []
    offs: list[float] = []
    radii: list[float] = []
    for seed in range(DISCS):
        row, column = rng.uniform(45, 65), rng.uniform(55, 75)
        found = find_balls(grey(draw(row, column, rng), noise=3.0, seed=seed), (14.0, 32.0))
        assert found
        best = min(found, key=lambda disc: float(np.hypot(disc.row - row, disc.column - column)))
        pulls += [(best.row - row) / best.row_sigma, (best.column - column) / best.column_sigma]
        offs += [best.row - row, best.column - column]
        radii.append((best.radius - RADIUS) / best.radius_sigma)
    assert 0.6 < np.sqrt(np.mean(np.square(pulls))) < 1.3
    assert np.sqrt(np.mean(np.square(radii))) < 1.3
    assert np.abs(pulls).max() < 4.5
    assert np.sqrt(np.mean(np.square(offs))) < 0.012 * RADIUS


def test_the_rim_is_found_from_a_circle_within_that_shares_a_side_with_it() -> None:
    rng = np.random.default_rng(3)
    for seed, turn in enumerate(np.linspace(0.0, 2.0 * np.pi, 6, endpoint=False)):
        row, column = rng.uniform(45, 65), rng.uniform(55, 75)
        off = 0.2 * RADIUS * np.array([np.sin(turn), np.cos(turn)])
        within = np.array([row + off[0], column + off[1], 0.8 * RADIUS])
        picture = np.atleast_3d(grey(blotched(row, column, rng), noise=3.0, seed=seed))
        found = fit_rim(picture.astype(np.float32), within, 1.2)
        assert found is not None
        assert found[0] == pytest.approx((row, column, RADIUS), abs=0.7)


def test_a_centre_known_to_a_few_hundredths_of_a_pixel_is_stated_so() -> None:
    rng = np.random.default_rng(4)
    pulls: list[float] = []
    for seed in range(DISCS // 2):
        row, column = rng.uniform(45, 65), rng.uniform(55, 75)
        light = GROUND + (BALL - GROUND) * coverage((row, column, RADIUS), SHAPE)
        (disc,) = find_balls(grey(light, noise=3.0, seed=seed), (14.0, 32.0))
        pulls += [(disc.row - row) / disc.row_sigma, (disc.column - column) / disc.column_sigma]
        assert max(disc.row_sigma, disc.column_sigma) < 0.03
    assert 0.3 < np.sqrt(np.mean(np.square(pulls))) < 1.3
