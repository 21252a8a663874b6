"""What the launches depend on is proposed, and nothing where they follow the settings alone."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.poses import PoseData
from analysis.model.proposals.document import proposals_document
from analysis.model.proposals.following import next_after
from analysis.model.proposals.propose import propose
from analysis.model.proposals.proposed import Proposed
from analysis.model.proposals.words import proposal_sentences
from tests.unit.analysis.model.proposals.hidden import SHOTS, campaign, proposed

PER_KELVIN = 0.01


def with_warm_pushers(data: PoseData, per_kelvin: float = PER_KELVIN) -> PoseData:
    """Return a campaign whose pushers gain speed with the temperature: v^2 goes as the pressure.

    The spheres are as fast as they were; the pressure that is noted is the one that a pusher of the
    law would have needed for it.
    """
    warm = data.covariates["temperature_c"] - 23.0
    noted = {
        name: values / (1.0 + per_kelvin * warm) ** 2 if name.startswith("pressure") else values
        for name, values in data.covariates.items()
    }
    return replace(data, covariates=noted)


@cache
def warm() -> Proposed:
    return propose(with_warm_pushers(campaign({}, 3)), (), CATALOGUE)


def test_pushers_that_follow_the_temperature_are_proposed_as_a_form_of_the_launch() -> None:
    found = warm()
    assert found.accepted == ()
    [one] = found.launch
    assert (one.form.quantity, one.form.argument) == ("speed", "temperature_c")
    assert "linear" in one.shapes
    assert one.p_familywise < 1e-4
    assert one.error_after < one.error_before
    if one.form.shape_name == "linear":
        slope = one.parameters["a"]
        assert abs(slope.value - PER_KELVIN) < 4 * slope.sigma
        assert slope.unit.endswith("^-1")


def test_a_form_of_the_launch_stands_in_the_document_as_any_other() -> None:
    found = warm()
    document = json.loads(json.dumps(proposals_document("x", found, next_after(found))))
    assert document["verdict"] == "proposal"
    [one] = document["proposals"]
    assert set(one) == set(
        proposals_document("y", proposed("restitution-bump", 0.008)[1])["proposals"][0]
    )
    assert (one["slot"], one["argument"]) == ("launch", "temperature_c")
    assert one["formula"].startswith("speed = speed by the settings x [1 + ")
    assert sum(shot["repeat"] for shot in one["next_shots"]) >= 8
    assert "how the spheres leave their tubes) depends on temperature_c" in " ".join(
        proposal_sentences(document)
    )


@pytest.mark.parametrize("seed", range(4))
def test_nothing_is_proposed_of_launches_that_follow_their_settings(seed: int) -> None:
    assert proposed(None, seed=seed)[1].launch == ()


def test_without_settings_the_launch_is_not_asked() -> None:
    data = campaign({}, 2)
    bare = {k: v for k, v in data.covariates.items() if not k.startswith(("pressure", "offset"))}
    assert propose(replace(data, covariates=bare), (), CATALOGUE).launch == ()


def test_a_track_that_moves_with_the_order_is_proposed_as_an_offset() -> None:
    data = campaign({}, 4)
    late = data.covariates["order"] > np.sort(data.covariates["order"])[SHOTS // 2]
    noted = {**data.covariates, "offset_mm": data.covariates["offset_mm"] - 1.3 * late}
    found = propose(replace(data, covariates=noted), (), CATALOGUE)
    one = found.launch[0]
    assert (one.form.quantity, one.form.argument) == ("track_offset", "order")
    assert "step" in one.shapes
