"""Reports of contacts that last: each number is true within its error, or said to be none."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from analysis.results.campaign import Results, results
from analysis.results.tables import tables
from benchmarks.discovery.campaigns import posed
from simulators.challenge.campaign import run_campaign
from simulators.challenge.force_choice import Forces
from simulators.challenge.nature import Nature

LASTING = Nature(forces=Forces(), drag_coefficient=0.4)
HARD = Nature(drag_coefficient=0.4)


@cache
def report(nature: Nature, seed: int) -> Results:
    data = posed(run_campaign(nature, seed, shots=30))
    return results(replace(data, drag_coefficient=0.42))


def test_the_two_lines_are_no_law_of_contacts_that_last() -> None:
    found = report(LASTING, 1)
    assert found.lasting
    assert set(found.coefficients()) == {"e"}
    assert "beta0" not in found.whole_fit


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.long) for seed in (2, 3))]
)
def test_the_law_of_contacts_that_last_stands_beside_with_true_errors(seed: int) -> None:
    truth = {"e": 0.74, "mu": 0.08, "lasting-contact.kappa": 0.15, "lasting-contact.zeta": 0.05}
    for name, value in truth.items():
        found = report(LASTING, seed).whole_fit[name]
        assert abs(found.value - value) < 3.5 * found.sigma, name


def test_the_mean_restitution_errs_as_much_as_it_says() -> None:
    """The mean of these shots is below 0.74, as e of oblique contacts is, and scatters less."""
    found = report(LASTING, 1)
    mean, each = found.coefficients()["e"], found.ratios.e
    weight = each.own**-2.0 if np.isfinite(each.own).all() else each.sigma**-2.0
    assert np.isclose(mean.value, np.average(each.value, weights=weight), atol=2e-5)
    assert mean.own is not None
    assert 0.0 < mean.own < 0.2 * np.median(each.own)
    assert mean.value < 0.7398


def test_hard_spheres_keep_their_two_lines() -> None:
    found = report(HARD, 1)
    assert not found.lasting
    assert set(found.coefficients()) == {"e", "mu", "beta0"}


def test_the_table_has_a_row_for_each_number_of_the_contact() -> None:
    rows = {row[0]: row for row in tables(report(LASTING, 1))["parameters"]}
    assert rows["beta0"][1:5] == ["", "", "", ""]
    assert rows["mu"][1:3] == ["", ""]
    assert abs(float(str(rows["lasting-contact.kappa"][3])) - 0.15) < 0.02
