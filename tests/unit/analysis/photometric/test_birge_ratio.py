"""Stated errors of poses are enlarged by what scatters, and by nothing that the air does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.motion.pattern import Orientations
from analysis.motion.poses import Centres
from analysis.photometric.birge_ratio import birge_ratios, scatter_ratio

Floats = NDArray[np.float64]
TIMES = np.arange(60) * 2.5e-4
CONTACT = 7.6e-3
SIGMA, SIGMA_TURN = 3e-6, 4e-4
G = 9.81


def fallen(velocity: Floats, slowing_per_m: float) -> Floats:
    """Return places on a way through the air, m, from the contact on; y'' = g - k |v| v."""
    places, place, v = [], np.zeros(3), velocity.copy()
    step = 2.5e-6
    for _ in range(3100):
        places.append(place.copy())
        place = place + step * v
        v = v + step * (G * np.array([1.0, 0.0, 0.0]) - slowing_per_m * np.linalg.norm(v) * v)
    return np.array(places)


def film(sign: float, slowing_per_m: float, rng: np.random.Generator) -> Centres:
    """Return a sphere that comes with 4 m/s and leaves with 3, filmed 60 times."""
    way = sign * np.array([0.0, 4.0, 0.5])
    after = fallen(np.array([0.2, -sign * 3.0, 0.1]), slowing_per_m)
    before = fallen(way, slowing_per_m)
    k = np.rint(np.abs(TIMES - CONTACT) / 2.5e-6).astype(int)
    incoming = before[k[0] - k.clip(max=k[0])] - before[k[0]]
    place = np.where((TIMES < CONTACT)[:, None], incoming, after[k])
    place = place + np.array([0.0, -sign * 0.0127, 0.0]) + SIGMA * rng.standard_normal((60, 3))
    return Centres(np.arange(60), place, np.full((60, 3), SIGMA))


def still(rng: np.random.Generator) -> Orientations:
    turns = SIGMA_TURN * rng.standard_normal((60, 3))
    rotation = np.eye(3) + np.cross(np.eye(3)[None], -turns[:, None])
    rotation = np.array([u @ v for u, _, v in map(np.linalg.svd, rotation)])
    return Orientations(
        frames=np.arange(60),
        rotation=rotation,
        covariance=np.tile(SIGMA_TURN**2 * np.eye(3), (60, 1, 1)),
        pattern=np.zeros((0, 3)),
        matches=(),
        left_out={},
    )


def found(slowing_per_m: float, wild: float = 1.0) -> Floats:
    """Return both ratios of several films, shape (films, 2)."""
    every = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        a, b = film(1.0, slowing_per_m, rng), film(-1.0, slowing_per_m, rng)
        a = replace(a, sigma=a.sigma / wild)
        every.append(birge_ratios((a, b), (still(rng), still(rng)), TIMES, G))
    return np.array(every)


def test_the_drag_of_the_air_is_no_scatter() -> None:
    plain, slowed = found(0.0), found(0.2)
    np.testing.assert_allclose(slowed[:, 0], plain[:, 0], atol=0.03)
    assert slowed[:, 0].max() < 1.2


def test_errors_stated_too_small_are_enlarged() -> None:
    # One sphere of two by a factor of three: (9 + 1) / 2.
    assert found(0.0, wild=3.0)[:, 0] == pytest.approx(5.0, abs=1.2)


@pytest.mark.parametrize("stated", [0.5, 1.0, 1.6])
def test_errors_of_outlines_become_what_scatters_about_flights(stated: float) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        a, b = (
            replace(own, sigma=stated * own.sigma)
            for own in (film(1.0, 0.1, rng), film(-1.0, 0.1, rng))
        )
        assert scatter_ratio((a, b), TIMES, G) == pytest.approx(stated**-2, rel=0.25)


def test_few_frames_say_nothing_of_their_scatter() -> None:
    rng = np.random.default_rng(1)
    near = np.abs(TIMES - CONTACT) < 1e-3
    a, b = (
        Centres(own.frames[near], own.position[near], 3.0 * own.sigma[near])
        for own in (film(1.0, 0.0, rng), film(-1.0, 0.0, rng))
    )
    assert scatter_ratio((a, b), TIMES, G) == 1.0
