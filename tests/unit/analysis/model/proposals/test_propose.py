"""What depends on what is found where something does, and nothing is proposed where nothing is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.errors import ProposalRefusedError
from analysis.model.proposals.document import proposals_document
from analysis.model.proposals.propose import propose
from simulators.challenge.unnamed import LAWS
from tests.unit.analysis.model.proposals.hidden import SHOTS, campaign, proposed

STRONG = {
    "restitution-bump": 0.008,
    "restitution-step": 0.008,
    "restitution-warm-and-fast": 0.004,
    "restitution-knee": 0.004,
    "friction-spin": 0.06,
    "friction-temperature": 0.02,
}
"""Twelve standard errors and more of what 60 shots see."""
QUICK = ("restitution-bump", "restitution-warm-and-fast", "friction-temperature")
"""One of each kind: a shape, a product, and another coefficient."""


@pytest.mark.parametrize(
    "name",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.long) for name in STRONG],
)
def test_a_hidden_law_is_proposed_with_its_slot_and_argument(name: str) -> None:
    _, found = proposed(name, STRONG[name])
    first, law = found.accepted[0], LAWS[name]
    assert (law.slot, law.argument) in [first.form.group, *first.alike]
    assert law.shape in first.shapes
    assert first.p_familywise < 1e-6
    assert first.after.error.value < first.before.error.value


def test_a_strong_law_keeps_its_shape() -> None:
    _, found = proposed("friction-temperature", 0.03, 45)
    first = found.accepted[0]
    assert (*first.form.group, first.form.shape_name) == ("mu", "temperature_c", "linear")
    assert abs(first.quantities["a"].value - 0.03) < 4 * first.quantities["a"].sigma


def test_the_constants_of_a_bump_are_found_within_their_errors() -> None:
    _, found = proposed("restitution-bump", STRONG["restitution-bump"])
    constants = found.accepted[0].freed.parameters()
    centre, width = (constants[f"proposal-1.{name}"] for name in "mw")
    assert abs(centre.value - 5.0) < 4 * centre.sigma
    assert abs(width.value - 0.6) < 4 * width.sigma
    assert centre.unit == width.unit == "m/s"


@pytest.mark.parametrize(
    "seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.long) for seed in (2, 3))]
)
def test_nothing_is_proposed_where_nothing_is_missing(seed: int) -> None:
    _, found = proposed(None, seed=seed)
    assert found.accepted == ()


@pytest.mark.parametrize(
    ("name", "amplitude"),
    [pytest.param("image-scale", 0.005, marks=pytest.mark.long), ("restitution-drift", 0.03)],
)
def test_what_the_catalogue_holds_is_named_and_not_proposed(name: str, amplitude: float) -> None:
    _, found = proposed(name, amplitude)
    assert found.accepted == ()
    assert name in found.effects
    assert proposals_document("x", found)["verdict"] == "effect"


def test_a_force_between_the_spheres_is_found_in_flight_with_its_exponent() -> None:
    _, found = proposed("attraction-power", 10.0)
    [only] = found.accepted
    assert only.form.group == ("flight", "distance")
    assert "power" in only.shapes
    if only.form.shape_name == "power":
        power = only.freed.parameters()["proposal-1.p"]
        assert abs(power.value - 4.0) < 4 * power.sigma


@pytest.mark.long
def test_a_force_that_pushes_apart_is_found_too() -> None:
    _, found = proposed("attraction-power", -10.0)
    assert found.accepted[0].form.group == ("flight", "distance")


def test_few_shots_are_refused_with_what_is_needed() -> None:
    with pytest.raises(ProposalRefusedError, match="5 shots: at least 12"):
        propose(campaign({}, 1, shots=5), (), CATALOGUE)


def test_a_column_that_copies_another_or_never_changes_is_named_with_what_would_part_them() -> None:
    data = campaign({}, 1)
    more = {"lamp_c": np.full(SHOTS, 31.0), "room_k": data.covariates["temperature_c"] + 273.15}
    found = propose(replace(data, covariates={**data.covariates, **more}), (), CATALOGUE)
    said = {one.argument: one for one in found.admitted.left_out}
    assert "the same in all shots, 31" in said["lamp_c"].reason
    assert {"room_k", "temperature_c"} & set(said)
    assert "pressure_a_kpa" in said["pressure_b_kpa"].todo


def test_a_law_on_a_column_with_a_copy_names_the_copy_beside_it() -> None:
    data = campaign({"restitution-temperature": 2e-3}, 4)
    more = {"room_k": data.covariates["temperature_c"] + 273.15}
    found = propose(replace(data, covariates={**data.covariates, **more}), (), CATALOGUE)
    [first] = proposals_document("nylon", found)["proposals"]
    named = {first["argument"], *(one["argument"] for one in first["alike"])}
    assert {"room_k", "temperature_c"} <= named


def test_arguments_that_run_together_are_named_with_shots_that_would_part_them() -> None:
    data = campaign({}, 1)
    near = data.covariates["temperature_c"] + np.random.default_rng(0).normal(0, 0.03, SHOTS)
    found = propose(replace(data, covariates={**data.covariates, "wall_c": near}), (), CATALOGUE)
    [pair] = [c for c in found.admitted.confounded if "wall_c" in c.arguments]
    assert set(pair.arguments) == {"temperature_c", "wall_c"}
    assert pair.correlation > 0.97
    assert "changes and" in pair.todo


def test_one_setting_leaves_only_what_varies_by_itself() -> None:
    data = campaign({}, 2)
    fixed = {
        name: np.full(SHOTS, values[0]) if name.startswith(("pressure", "offset")) else values
        for name, values in data.covariates.items()
    }
    found = propose(replace(data, covariates=fixed), (), CATALOGUE)
    said = {one.argument for one in found.admitted.left_out}
    assert {"pressure_a_kpa", "pressure_b_kpa", "offset_mm"} <= said
