"""Coefficients of single shots and e against speed."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.results.campaign import speed_line
from analysis.results.impacts import Impacts
from analysis.results.ratios import ratios, velocities
from tests.unit.analysis.results.measured import LEVER, both_regimes, impacts


def test_coefficients_of_a_shot_are_those_of_the_definitions() -> None:
    row = np.array([[-2.0, 1.0, 1.5, 0.25]])
    found = ratios(Impacts(np.array([7]), row, 1e-6 * np.eye(4)[None], LEVER))
    assert found.e.value[0] == pytest.approx(0.75)
    assert found.beta.value[0] == pytest.approx(-0.25)
    assert found.f.value[0] == pytest.approx(0.75 / (3.5 * 3.5))
    assert (found.incidence.value[0], found.rebound.value[0]) == pytest.approx((0.5, 0.125))
    # sigma(e)^2 = (1 + e^2) sigma^2 / v_n^2 for equal, uncorrelated errors.
    assert found.e.sigma[0] == pytest.approx(1e-3 * np.sqrt(1 + 0.75**2) / 2, rel=1e-5)
    # Both axes share the error of v_n alone: x y / sqrt((1 + x^2) (1 + y^2)).
    shared = 0.5 * 0.125 / np.sqrt((1 + 0.25) * (1 + 0.125**2))
    assert found.correlation[0] == pytest.approx(shared, rel=1e-5)


def test_what_all_shots_share_is_told_apart_in_every_coefficient() -> None:
    row, own = np.array([[-2.0, 1.0, 1.5, 0.25]]), 1e-6 * np.eye(4)[None]
    shared = np.zeros((1, 5, 4))
    shared[0, 0] = 1e-3 * row[0]
    held = shared[:, :2]
    whole = own + held.swapaxes(1, 2) @ held
    found = Impacts(np.array([7]), row, whole, LEVER, shared=shared)
    # A scale moves all speeds alike: it is in each of them, and in no ratio.
    for k, speed in enumerate(velocities(found)):
        assert speed.common[0] == pytest.approx(1e-3 * abs(row[0, k]))
        assert speed.own[0] == pytest.approx(1e-3)
    each = ratios(found)
    for ratio in (each.e, each.beta, each.f):
        assert ratio.common[0] == pytest.approx(0.0, abs=1e-9)
        assert ratio.own[0] == pytest.approx(ratio.sigma[0])
    assert np.isnan(ratios(Impacts(np.array([7]), row, own, LEVER)).e.common).all()


def test_errors_of_coefficients_are_those_of_repeated_measurements() -> None:
    rng = np.random.default_rng(2)
    root = rng.normal(0, 0.004, (4, 4))
    mean = np.array([-2.0, 1.0, 1.5, 0.25])
    drawn = mean + rng.normal(size=(20_000, 4)) @ root.T
    same = np.tile(root @ root.T, (len(drawn), 1, 1))
    found = ratios(Impacts(np.arange(len(drawn)), drawn, same, LEVER))
    for ratio in (found.e, found.beta, found.f, found.incidence, found.rebound):
        assert np.std(ratio.value) == pytest.approx(float(np.median(ratio.sigma)), rel=0.05)
    pair = np.corrcoef(found.incidence.value, found.rebound.value)[0, 1]
    assert pair == pytest.approx(float(np.median(found.correlation)), abs=0.03)


def test_what_was_not_measured_has_no_coefficient() -> None:
    row = np.array([[-2.0, np.nan, 1.5, np.nan]])
    found = ratios(Impacts(np.array([7]), row, 1e-6 * np.eye(4)[None], LEVER))
    assert np.isfinite([found.e.value[0], found.e.sigma[0]]).all()
    assert np.isnan([found.beta.value[0], found.beta.sigma[0], found.f.sigma[0]]).all()


def test_restitution_that_falls_with_speed_is_seen_as_a_slope() -> None:
    pulls = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        speed = rng.uniform(1, 5, 25)
        found = impacts(rng, both_regimes(rng, 25), law=(1.0, 0.08, 0.69), approach=speed)
        # e = 1 was drawn; e = 0.8 - 0.02 |v_n| is put in its place, errors as they are.
        found.velocities[:, 2] += (0.8 - 0.02 * speed - 1.0) * speed
        line = speed_line(found, ratios(found), np.ones(25, dtype=np.bool_))
        assert line is not None
        pulls.append((line.slope + 0.02) / np.sqrt(line.covariance[0, 0]))
    assert np.mean(pulls) == pytest.approx(0, abs=4 / np.sqrt(60))
    assert np.std(pulls) == pytest.approx(1, abs=4 / np.sqrt(120))
