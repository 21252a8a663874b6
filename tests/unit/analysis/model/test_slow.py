"""Errors that the frames of a flight share are whitened as what they are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import sqrtm
from scipy.spatial.transform import Rotation

from analysis.effects.catalogue import CATALOGUE
from analysis.exchange.description import read_description
from analysis.exchange.folder import description
from analysis.model.data.gather import gather
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.predict.comparison import compare
from analysis.model.rank.ranking import rank
from analysis.setup import NO_SLOW_ERRORS, SlowErrors
from tests.unit.analysis.model.exchange_folder import write_campaign
from tests.unit.analysis.model.hard_spheres import campaign

Floats = NDArray[np.float64]
PLACE_M, TURN_RAD, MEMORY_RAD = 1.5e-5, 4e-3, 0.2
POINTS = 300


def line_covariance(ends_s: Floats, lasting_s: float) -> Floats:
    """Return that of a line's value at time 0 and slope, drawn through an error of size 1.

    By least squares through many points of an error that forgets itself exponentially.
    """
    times = np.linspace(ends_s[0], ends_s[-1], POINTS)
    drawn = np.linalg.pinv(np.stack([np.ones_like(times), times], axis=1))
    lasting = np.exp(-np.abs(times[:, None] - times) / lasting_s)
    return np.asarray(drawn @ lasting @ drawn.T)


def lasting_s(spin: Floats) -> float:
    """Return the time in which a sphere of some spin, rad/s, turns by what its markers are wide."""
    return float(np.clip(MEMORY_RAD / np.linalg.norm(spin), 1e-3, 1.0))


def drifting(shots: int, seed: int) -> PoseData:
    """Return a campaign in which each side of each track stands off and leans, frames together."""
    data = campaign(shots, seed)
    fit = fit_campaign(data)
    _, shown = compare(data, fit.states, fit.theory)
    rng = np.random.default_rng(seed)
    position, turns = data.position.copy(), np.zeros(data.position.shape)
    for shot, i, side in np.ndindex(shots, 2, 2):
        tau = data.times_s[shot] - fit.states.time_s[shot]
        own = (tau > 0) == bool(side)
        ends = tau[own][[0, -1]]
        lines = line_covariance(ends, lasting_s(shown.sides.spin[shot, i, side]))
        for size, errors in ((PLACE_M, position), (TURN_RAD, turns)):
            start, rate = size * rng.multivariate_normal(np.zeros(2), lines, 3).T
            errors[shot, own, i] += start + np.outer(tau[own], rate)
    turned = Rotation.from_rotvec(turns.reshape(-1, 3)).as_matrix().reshape(data.rotation.shape)
    return replace(data, position=position, rotation=turned @ data.rotation)


def stated(data: PoseData) -> PoseData:
    return replace(data, slow=SlowErrors(PLACE_M, TURN_RAD, memory_rad=MEMORY_RAD))


def test_whitening_is_the_inverse_root_of_the_whole_covariance() -> None:
    data = stated(campaign(2, 3))
    fit = fit_campaign(data)
    line, shown = compare(data, fit.states, fit.theory)
    bare, _ = compare(replace(data, slow=NO_SLOW_ERRORS), fit.states, fit.theory)
    for shot in (0, 1):
        for block, size in enumerate([PLACE_M, TURN_RAD] * 2):
            slopes, tau = bare.slopes[shot, block], data.times_s[shot] - fit.states.time_s[shot]
            of_numbers = np.zeros((12, 12))
            for side, own in enumerate((tau <= 0, tau > 0)):
                ends = tau[own][[0, -1]]
                lines = line_covariance(ends, lasting_s(shown.sides.spin[shot, block // 2, side]))
                of_numbers[6 * side :][:6, 6 * side :][:, :6] = np.kron(lines, np.eye(3))
            covariance = np.eye(len(slopes)) + size**2 * slopes @ of_numbers @ slopes.T
            root = np.linalg.inv(np.real(sqrtm(covariance)))
            expected = root @ bare.residual[shot, block]
            assert line.residual[shot, block] == pytest.approx(expected, abs=5e-3)


def test_without_a_spin_rates_are_as_wrong_as_they_can_be() -> None:
    data = replace(campaign(2, 3), slow=SlowErrors(PLACE_M, TURN_RAD))
    data = replace(data, rotation_sigma=np.full(data.rotation_sigma.shape, np.inf))
    fit = fit_campaign(data)
    line, _ = compare(data, fit.states, fit.theory)
    tau = data.times_s[0] - fit.states.time_s[0]
    before = tau[tau <= 0]
    span = before.max() - before.min()
    worst = max(line_covariance(before[[0, -1]], span / x)[1, 1] for x in np.arange(2, 6, 0.1))
    leaning = np.where(tau <= 0, tau - before.mean(), 0.0)[:, None] * np.array([1.0, 0, 0])
    felt = leaning.ravel() / data.position_sigma[0, :, 0].ravel()
    assert line.shared is not None
    assert line.shared.slow is not None
    whitened = np.sum(line.shared.slow.whiten(np.tile(felt[:, None], (2, 4, 1, 1)))[0, 0] ** 2)
    assert whitened == pytest.approx(1 / (1 / (felt @ felt) + PLACE_M**2 * worst), rel=0.03)


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
