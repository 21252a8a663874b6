"""Several campaigns say together what each alone would whisper."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from analysis.errors import ProposalRefusedError
from analysis.model.data.poses import PoseData
from analysis.model.proposals.channels import Sums
from analysis.model.proposals.together import (
    OwnSums,
    Together,
    own_sums,
    place,
    propose_together,
)
from tests.unit.analysis.model.proposals.hidden import campaign

LAW = "restitution-temperature"
FAINT = 2.5e-4
"""Relative change of e for each kelvin: three to four standard errors in one campaign."""


@cache
def campaigns(*sizes: float) -> tuple[PoseData, ...]:
    return tuple(campaign({LAW: size}, 20 + k) for k, size in enumerate(sizes))


@cache
def of_four() -> tuple[Together, int]:
    """Return what four campaigns propose together, and how often the mapper was asked.

    That processes give the same answer as none is tested by `rigctl model propose --workers`.
    """
    seen = []

    def mapped(function: object, items: object) -> list[object]:
        seen.append(function)
        return [function(item) for item in items]  # type: ignore[operator,attr-defined]

    return propose_together(campaigns(FAINT, FAINT, FAINT, FAINT), (), mapped), len(seen)


def test_a_law_too_faint_for_one_campaign_is_found_in_several() -> None:
    found, asked = of_four()
    assert asked == 2
    first = found.forms[0]
    assert (first.slot, first.argument) == ("e", "temperature_c")
    assert abs(first.amplitude - FAINT) < 4 * first.sigma or first.shape != "linear"
    assert first.p_alike > 1e-3
    assert len(first.each) == 4


def test_campaigns_that_differ_are_said_to_have_each_its_own() -> None:
    found = propose_together(campaigns(2e-3, 5e-4, 1.2e-3), ())
    first = next(one for one in found.forms if one.argument == "temperature_c")
    assert first.p_alike < 1e-6


@pytest.mark.long
def test_what_the_catalogue_holds_of_a_campaign_is_no_law_that_they_share() -> None:
    off = tuple(campaign({LAW: 1e-3, "image-scale": 0.01}, seed) for seed in (41, 42))
    found = propose_together(off, ())
    assert found.effects == (("image-scale",), ("image-scale",))
    assert [(one.slot, one.argument) for one in found.forms] == [("e", "temperature_c")]


def test_nothing_is_proposed_where_nothing_is_hidden() -> None:
    assert propose_together(campaigns(0.0, 0.0), ()).forms == ()


def test_sums_add_up_as_if_the_columns_stood_below_each_other() -> None:
    rng = np.random.default_rng(0)
    tall = [rng.normal(size=(50, 3)) for _ in range(2)]
    residual = [rng.normal(size=50) for _ in range(2)]
    parts = [
        Sums(u.T @ u, u.T @ r, (u**2).sum(axis=0)) for u, r in zip(tall, residual, strict=True)
    ]
    both = parts[0] + parts[1]
    stacked = np.concatenate(tall)
    np.testing.assert_allclose(both.matrix, stacked.T @ stacked)
    np.testing.assert_allclose(both.gradient, stacked.T @ np.concatenate(residual))


def test_what_a_campaign_sends_is_small_and_does_not_grow_with_its_shots() -> None:
    data = campaigns(0.0, 0.0)[0]
    placed = place(data, ())
    sent: OwnSums = own_sums(data, (), placed.spreads)
    assert sent.sums.matrix.shape == (len(sent.labels), len(sent.labels))


def test_a_campaign_of_few_shots_is_refused() -> None:
    with pytest.raises(ProposalRefusedError, match="5 shots takes no part"):
        propose_together([campaign({}, 1, shots=5)], ())
