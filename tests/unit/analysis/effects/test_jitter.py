"""Jitter of the frames' times: against covariances written out, and drawn residuals."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.effects.clock import timing_jitter
from analysis.effects.clock.jitter_score import JitterScore, directions, score_of

Floats = NDArray[np.float64]

SHOTS, FRAMES, OWN = 40, 20, 24
JITTER_S = 1e-5


def rates(rng: np.random.Generator) -> Floats:
    """Return speeds of 2 to 5 m/s over 30 um, and spins of 100 rad/s over 8 mrad."""
    along = rng.normal(0, 3e3, (SHOTS, FRAMES, 2, 6))
    along[..., 1] = rng.uniform(2, 5, (SHOTS, 1, 1)) / 3e-5 * np.array([1.0, -1.0])
    along[..., 3:] = rng.normal(0, 100 / 8e-3, (SHOTS, 1, 2, 3))
    return along


def fitted_away(rng: np.random.Generator) -> Callable[[Floats], Floats]:
    """Return the projection off 24 smooth columns a shot, those of a straight flight among them."""
    columns = rng.normal(size=(SHOTS, FRAMES * 12, OWN))
    basis = np.linalg.qr(columns)[0]
    return lambda x: x - basis @ (np.swapaxes(basis, 1, 2) @ x)


def spread_of(along: np.ndarray) -> np.ndarray:
    """Return the disturbances with a column for each frame, (S, 12 F, F)."""
    shots, frames = along.shape[:2]
    spread = np.zeros((shots, 12 * frames, frames))
    for f in range(frames):
        spread[:, 12 * f : 12 * f + 12, f] = along[:, f].reshape(shots, -1)
    return spread


def scored(seed: int, jitter_s: float, noise: float = 1.0) -> JitterScore:
    rng = np.random.default_rng(seed)
    along, project = rates(rng), fitted_away(rng)
    errors = jitter_s * rng.normal(size=(SHOTS, FRAMES, 1, 1))
    raw = noise * rng.normal(size=along.shape) + along * errors
    residual = project(raw.reshape(SHOTS, -1, 1)).reshape(along.shape)
    spread = spread_of(along)
    kernel = np.swapaxes(spread, 1, 2) @ project(spread)
    return score_of([directions(residual, along, kernel)], SHOTS * (FRAMES * 12 - OWN))


def test_the_amplitude_is_found_within_its_error() -> None:
    pulls = []
    for seed in range(12):
        found = scored(seed, JITTER_S)
        pulls.append((found.amplitude - JITTER_S) / found.sigma)
        assert found.z > 5
        assert found.p_delta_chi2 < 1e-6
    assert abs(np.mean(pulls)) < 3 / np.sqrt(12)
    assert 0.5 < np.std(pulls) < 1.7


def test_frames_on_time_give_scores_of_a_unit_gaussian() -> None:
    scores = np.array([scored(seed, 0.0).z for seed in range(60)])
    assert abs(scores.mean()) < 3.5 / np.sqrt(60)
    assert 0.7 < scores.std() < 1.3


def test_misstated_noise_alone_is_no_jitter() -> None:
    scores = np.array([scored(seed, 0.0, noise=1.3).z for seed in range(20)])
    assert abs(scores.mean()) < 3.5 / np.sqrt(20)


def test_noise_and_jitter_in_proportion_leave_the_score_and_scale_the_amplitude() -> None:
    one, twice = scored(3, JITTER_S), scored(3, 2 * JITTER_S, noise=2.0)
    assert twice.z == pytest.approx(one.z, rel=1e-9)
    assert twice.delta_chi2 == pytest.approx(one.delta_chi2, rel=1e-6)
    assert twice.amplitude == pytest.approx(2 * one.amplitude, rel=1e-4)


def test_no_amplitude_is_claimed_where_residuals_are_calmer_along_the_tracks() -> None:
    calm = next(found for found in (scored(k, 0.0) for k in range(20)) if found.z < -0.5)
    assert (calm.amplitude, calm.delta_chi2, calm.p_delta_chi2) == (0.0, 0.0, 1.0)
    assert 0 < calm.sigma < JITTER_S


def test_the_score_is_the_slope_of_the_likelihood_of_the_whole_covariance() -> None:
    """One shot, the projected covariance written out in an orthonormal basis of what is left."""
    rng = np.random.default_rng(5)
    frames, own = 4, 6
    along = rng.normal(0, 1, (1, frames, 2, 6))
    columns = rng.normal(size=(frames * 12, own))
    left = np.linalg.svd(columns, full_matrices=True)[0][:, own:]
    projector = left @ left.T
    residual = (projector @ rng.normal(size=frames * 12)).reshape(along.shape)
    freedom = frames * 12 - own
    spread = spread_of(along)[0]
    seen_so = directions(residual, along, (spread.T @ projector @ spread)[None])
    found = score_of([seen_so], freedom)
    reduced, seen = left.T @ spread, left.T @ residual.reshape(-1)

    def log_likelihood(w: float, f: float) -> float:
        covariance = f * np.eye(freedom) + w * reduced @ reduced.T
        _, logdet = np.linalg.slogdet(covariance)
        return float(-0.5 * (logdet + seen @ np.linalg.solve(covariance, seen)))

    noise, step = float(seen @ seen) / freedom, 1e-6
    slope = (log_likelihood(step, noise) - log_likelihood(-step, noise)) / (2 * step)
    kernel = reduced.T @ reduced
    information = (np.trace(kernel @ kernel) - np.trace(kernel) ** 2 / freedom) / (2 * noise**2)
    assert found.z == pytest.approx(slope / np.sqrt(information), rel=1e-5)


def test_whitening_gives_jittered_noise_unit_covariance() -> None:
    rng = np.random.default_rng(2)
    along = rng.normal(0, 4e4, (1, 2, 12))
    values = np.array([2e-5])
    covariance = np.eye(24)
    for f in range(2):
        own = slice(12 * f, 12 * f + 12)
        covariance[own, own] += values[0] ** 2 * np.outer(along[0, f], along[0, f])
    root = timing_jitter.EFFECT.whiten(np.eye(24)[None], along, values)[0]
    assert root @ covariance @ root.T == pytest.approx(np.eye(24), abs=1e-12)


def test_whitening_without_jitter_or_motion_changes_nothing() -> None:
    columns = np.random.default_rng(1).normal(size=(3, 24, 2))
    off = timing_jitter.EFFECT.whiten(columns, np.full((3, 2, 12), 1e4), timing_jitter.EFFECT.off)
    still = timing_jitter.EFFECT.whiten(columns, np.zeros((3, 2, 12)), np.array([1e-5]))
    assert np.array_equal(off, columns)
    assert np.array_equal(still, columns)


def test_frames_in_which_nothing_moves_are_refused() -> None:
    nothing = np.zeros((1, 3, 2, 6))
    with pytest.raises(ValueError, match="nothing moves"):
        score_of([directions(nothing + 1.0, nothing, np.zeros((1, 3, 3)))], 10)
    with pytest.raises(ValueError, match="0 degrees of freedom"):
        score_of([directions(nothing, nothing, np.zeros((1, 3, 3)))], 0)
