"""What a laboratory may do to its data: bad shots, wrong sigmas, no orientations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from analysis.model.data.poses import PoseData

Floats = NDArray[np.float64]
Treatment = Callable[[PoseData, np.random.Generator], PoseData]
Spoiler = Callable[[Floats, Floats, np.random.Generator], None]
"""Spoils one shot in place: centres (F, 2, 3), orientations (F, 2, 3, 3)."""

BAD_SHARE, MISTRACKED_SHARE = 0.03, 0.12


def _turned(rng: np.random.Generator, angle: float) -> Floats:
    axis = rng.normal(size=3)
    return Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()


def _slipped(centres: Floats, turned: Floats, rng: np.random.Generator) -> None:
    """Take the markers for another of the pattern's places from the contact on."""
    sphere, half = rng.integers(2), len(turned) // 2
    turned[half:, sphere] = turned[half:, sphere] @ _turned(rng, rng.uniform(0.1, 1.2))


def _hidden_edge(centres: Floats, turned: Floats, rng: np.random.Generator) -> None:
    """Hide part of an outline for some frames: the centre leans to one side, ever more."""
    sphere, first = rng.integers(2), rng.integers(4, len(centres) - 8)
    lean = np.linspace(0.0, 1.0, len(centres) - first)[:, None] * rng.normal(0, 3e-4, 3)
    centres[first:, sphere] += lean


def _exchanged(centres: Floats, turned: Floats, rng: np.random.Generator) -> None:
    """Exchange the two spheres' tracks for a few frames about the contact."""
    first = rng.integers(len(centres) // 2 - 3, len(centres) // 2 + 1)
    some = slice(first, first + rng.integers(2, 5))
    centres[some] = centres[some, ::-1].copy()


def _chipped(centres: Floats, turned: Floats, rng: np.random.Generator) -> None:
    """Fire a sphere with a chip: it leaves the contact with another velocity and spin."""
    sphere, half = rng.integers(2), len(centres) // 2
    ms = np.arange(1, len(centres) - half + 1)[:, None]
    centres[half:, sphere] += ms * rng.normal(0, 5e-5, 3)
    spin = Rotation.from_rotvec(ms * rng.normal(0, 8e-3, 3)).as_matrix()
    turned[half:, sphere] = spin @ turned[half:, sphere]


def _drifting(centres: Floats, turned: Floats, rng: np.random.Generator) -> None:
    """Let the orientation run away little by little, as a pattern found ever worse does."""
    sphere = rng.integers(2)
    away = np.linspace(0.0, 1.0, len(turned))[:, None] * rng.normal(0, 0.25, 3)
    turned[:, sphere] = Rotation.from_rotvec(away).as_matrix() @ turned[:, sphere]


BAD: tuple[Spoiler, ...] = (_slipped, _hidden_edge, _exchanged, _chipped, _drifting)


def spoilt(data: PoseData, rng: np.random.Generator) -> PoseData:
    """Return the data with some shots bad in one of five ways, and single frames wild."""
    centres, turned = data.position.copy(), data.rotation.copy()
    for s in range(len(data.shots)):
        if rng.random() < BAD_SHARE:
            BAD[rng.integers(len(BAD))](centres[s], turned[s], rng)
        if rng.random() < MISTRACKED_SHARE:
            frame, sphere = rng.integers(centres.shape[1]), rng.integers(2)
            if rng.random() < 0.5:
                turned[s, frame, sphere] = _turned(rng, 0.5) @ turned[s, frame, sphere]
            else:
                centres[s, frame, sphere] += rng.normal(0, 5e-4, 3)
    return replace(data, position=centres, rotation=turned)


def misstated(data: PoseData, rng: np.random.Generator) -> PoseData:
    """Return the data with sigmas of positions 30 % too large, of orientations 20 % too small."""
    return data.with_sigmas(1.3 * data.position_sigma, 0.8 * data.rotation_sigma)


def blind(data: PoseData, rng: np.random.Generator) -> PoseData:
    """Return the data without orientations."""
    return replace(data, rotation_sigma=np.full_like(data.rotation_sigma, np.inf))


def untouched(data: PoseData, rng: np.random.Generator) -> PoseData:
    return data


TREATMENTS: Mapping[str, Treatment] = {
    "as stated": untouched,
    "bad shots": spoilt,
    "wrong sigmas": misstated,
    "no orientations": blind,
}
