"""Errors that the frames of a flight share are whitened as what they are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import sqrtm
from scipy.spatial.transform import Rotation

from analysis.effects.catalogue import CATALOGUE
from analysis.exchange.description import read_description
from analysis.exchange.folder import description
from analysis.model.data.gather import gather
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.fitting.slow import RATE_FACTOR
from analysis.model.predict.comparison import compare
from analysis.model.rank.ranking import rank
from analysis.setup import NO_SLOW_ERRORS, SlowErrors
from tests.unit.analysis.model.exchange_folder import write_campaign
from tests.unit.analysis.model.hard_spheres import campaign

PLACE_M, TURN_RAD = 1.5e-5, 4e-3


def drifting(shots: int, seed: int) -> PoseData:
    """Return a campaign in which each side of each track stands off and leans, frames together."""
    data = campaign(shots, seed)
    contact = fit_campaign(data).states.time_s
    rng = np.random.default_rng(seed)
    after = data.times_s > contact[:, None]
    tau = data.times_s - contact[:, None]
    position, rotation = data.position, data.rotation
    for side in (False, True):
        mask = (after == side)[..., None, None]
        span = np.where(mask[..., 0, 0], tau, 0.0)
        span = (span.max(axis=1) - span.min(axis=1))[:, None, None, None]
        errors = []
        for size in (PLACE_M, TURN_RAD):
            start = rng.normal(0, size, (shots, 1, 2, 3))
            rate = rng.normal(0, RATE_FACTOR * size, (shots, 1, 2, 3)) / span
            errors.append(np.where(mask, start + rate * tau[..., None, None], 0.0))
        position = position + errors[0]
        turn = Rotation.from_rotvec(errors[1].reshape(-1, 3)).as_matrix()
        rotation = turn.reshape(rotation.shape) @ rotation
    return replace(data, position=position, rotation=rotation)


def stated(data: PoseData) -> PoseData:
    return replace(data, slow=SlowErrors(PLACE_M, TURN_RAD))


def test_whitening_is_the_inverse_root_of_the_whole_covariance() -> None:
    data = stated(campaign(2, 3))
    fit = fit_campaign(data)
    line, _ = compare(data, fit.states, fit.theory)
    bare, _ = compare(replace(data, slow=NO_SLOW_ERRORS), fit.states, fit.theory)
    assert line.shared is not None
    assert line.shared.slow is not None
    for shot in (0, 1):
        for block, (size, word) in enumerate([(PLACE_M, 0), (TURN_RAD, 1)] * 2):
            slopes = bare.slopes[shot, block]
            tau = data.times_s[shot] - fit.states.time_s[shot]
            sizes = np.zeros((2, 2, 3))
            for side, mask in enumerate((tau <= 0, tau > 0)):
                seen = tau[mask & data.measured[shot].any(axis=(1, 2))]
                sizes[side, 0] = size
                sizes[side, 1] = RATE_FACTOR * size / (seen.max() - seen.min())
            covariance = np.eye(len(slopes)) + (slopes * sizes.ravel() ** 2) @ slopes.T
            root = np.linalg.inv(np.real(sqrtm(covariance)))
            assert line.residual[shot, block] == pytest.approx(
                root @ bare.residual[shot, block], abs=1e-6
            ), word


def test_with_them_stated_chi_squared_is_one_and_errors_are_true() -> None:
    pulls = []
    for seed in range(4):
        data = drifting(40, 70 + seed)
        careless, careful = fit_campaign(data), fit_campaign(stated(data))
        assert careless.chi2_per_dof > 1.05
        assert careful.chi2_per_dof == pytest.approx(1.0, abs=5 * np.sqrt(2 / careful.freedom))
        e, mu = (careful.parameters()[name] for name in ("e", "mu"))
        assert e.sigma > 1.2 * careless.parameters()["e"].sigma
        pulls += [(e.value - 0.74) / e.sigma, (mu.value - 0.08) / mu.sigma]
    assert np.sqrt(np.mean(np.square(pulls))) < 2.0


def test_campaign_toml_hands_them_on(tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "c", campaign(3, 5))
    path = folder / "campaign.toml"
    _, setup = read_description(path)
    known = replace(setup, measurement=SlowErrors(3e-6, 2e-4))
    path.write_text(description("drifting", known), encoding="utf-8")
    _, data = gather(folder)
    assert isinstance(data, PoseData)
    assert data.slow == SlowErrors(3e-6, 2e-4)


def test_body_axes_of_each_shots_own_leave_nothing_to_say_of_the_centre_of_mass() -> None:
    data = replace(campaign(20, 6), slow=SlowErrors(one_body_frame=False))
    ranking = rank(data, fit_campaign(data), CATALOGUE)
    assert not next(c for c in ranking.candidates if c.effect.name == "mass-offset").seen
