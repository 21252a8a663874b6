"""A proposal in sentences and formulas that a person can read."""

from __future__ import annotations

import json

import pytest

from analysis.launch.prediction import Limits
from analysis.model.proposals.document import proposals_document
from analysis.model.proposals.following import next_after
from analysis.model.proposals.words import proposal_sentences, together_sentences
from analysis.quantity import Quantity
from tests.unit.analysis.model.proposals.hidden import proposed


def test_a_bump_is_said_with_formula_constants_errors_and_units() -> None:
    _, found = proposed("restitution-bump", 0.008)
    document = json.loads(json.dumps(proposals_document("nylon", found), allow_nan=False))
    said = " ".join(proposal_sentences(document))
    assert "nylon, 60 shots: a law is proposed." in said
    assert "e (the coefficient of restitution) depends on speed_n (the normal speed" in said
    assert "e = e0 [1 + a exp(-(v_n - m)^2 / (2 w^2))]" in said
    assert "m/s" in said
    assert "(1 is noise alone)" in said
    assert "ask with --confirm" in said
    assert "pressure_b_kpa is not tested: one and the same as pressure_a_kpa" in said


@pytest.mark.parametrize(
    ("value", "sigma", "said"),
    [
        (4.89e-4, 6.2e-5, "a = 0.000489 +- 0.000062 K^-1"),
        (-1.23456e-6, 2.0e-7, "a = (-1.23 +- 0.20) x 10^-6 K^-1"),
        (5.0012, 0.0141, "a = 5.001 +- 0.014 K^-1"),
        (1234.5, 67.0, "a = 1234 +- 67 K^-1"),
    ],
)
def test_a_value_has_as_many_digits_as_its_error(value: float, sigma: float, said: str) -> None:
    document = proposals_document("nylon", proposed("restitution-bump", 0.008)[1])
    document["proposals"][0]["parameters"] = {"a": Quantity(value, sigma, "K^-1").to_json()}
    assert said in " ".join(proposal_sentences(document))


def test_shots_for_a_law_on_what_nobody_sets_say_what_must_change_beside() -> None:
    document = proposals_document("nylon", proposed("restitution-bump", 0.008)[1])
    one = document["proposals"][0]
    one["next_shots"] = [{"pressure_a_kpa": 40.0}]
    assert "next shots do not change" not in " ".join(proposal_sentences(document))
    one["argument"] = "speed_n*temperature_c"
    assert "its next shots do not change temperature_c: fire" in " ".join(
        proposal_sentences(document)
    )


@pytest.mark.parametrize(
    ("second", "p_alike", "said"),
    [
        (None, 1.0, "one campaign alone can see it"),
        (0.02, 0.6, "the same in all that see it"),
        (0.9, 1e-6, "each its own"),
    ],
)
def test_campaigns_share_what_two_of_them_see(
    second: float | None, p_alike: float, said: str
) -> None:
    each = [
        {"campaign": "one", "amplitude": 0.021, "sigma": 0.002},
        {"campaign": "two", "amplitude": second, "sigma": None if second is None else 0.002},
    ]
    shared = {"slot": "e", "argument": "order", "shape": "linear", "amplitude": 0.02}
    shared |= {"sigma": 0.001, "p_familywise": 1e-5, "p_alike": p_alike, "each": each}
    document = {"campaigns": ["one", "two"], "with": [], "shared": [shared]}
    assert said in " ".join(together_sentences(document))


def test_a_chance_that_no_experiment_knows_is_no_number() -> None:
    document = proposals_document("nylon", proposed("restitution-bump", 0.008)[1])
    document["proposals"][0]["p_familywise"] = 1e-300
    assert "in some form: less than 1e-12" in " ".join(proposal_sentences(document))


def test_what_is_missing_and_has_no_form_is_said() -> None:
    document = proposals_document("nylon", proposed(None)[1])
    document["path"][-1]["prediction_error"] = 1.3
    said = " ".join(proposal_sentences(document))
    assert "no law is proposed" in said
    assert "something is missing, and it is none of the forms that are tried" in said


def test_what_laws_leave_over_is_said_where_it_is_much() -> None:
    document = proposals_document("nylon", proposed("restitution-bump", 0.008)[1])
    assert "is not all" not in " ".join(proposal_sentences(document))
    document["path"][-1]["prediction_error"] = 1.1764
    said = " ".join(proposal_sentences(document))
    assert "the error is still 1.176, and 1 is noise alone: what is named is not all" in said


def test_a_law_on_a_setting_is_said_to_stand_for_something_else() -> None:
    document = proposals_document("nylon", proposed("restitution-bump", 0.008)[1])
    assert "set by the rig" not in " ".join(proposal_sentences(document))
    document["proposals"][0]["argument"] = "pressure_a_kpa"
    said = " ".join(proposal_sentences(document))
    assert "pressure_a_kpa is set by the rig and acts through how the spheres meet" in said


def test_nothing_and_a_known_effect_are_said_as_such() -> None:
    nothing = proposal_sentences(proposals_document("nylon", proposed(None)[1]))
    assert "no law is proposed." in nothing[0]
    known = proposal_sentences(proposals_document("nylon", proposed("image-scale", 0.005)[1]))
    assert "image-scale of the catalogue is what is missing; no new law is needed" in known[0]


@pytest.mark.parametrize(
    ("name", "amplitude", "text", "latex"),
    [
        (
            "restitution-warm-and-fast",
            0.004,
            "e = e0 [1 + a ln(v_n / ",
            r"e = e_{0}\,[1 + a\,\ln(v_n/",
        ),
        ("attraction-power", 10.0, "k (D / d)^p toward b", r"(D/d)^{p}"),
        ("friction-temperature", 0.02, "mu = mu0 [1 + a (T - ", r"\mu = \mu_{0}\,[1 + a\,(T-"),
    ],
)
def test_a_formula_is_written_in_text_and_in_latex(
    name: str, amplitude: float, text: str, latex: str
) -> None:
    document = proposals_document("x", proposed(name, amplitude)[1])
    first = document["proposals"][0]
    assert text in first["formula"]
    assert latex in first["latex"]


def test_next_shots_stay_within_what_the_rig_allows() -> None:
    _, found = proposed("restitution-bump", 0.008)
    limits = Limits((20.0, 60.0), (2.0, 10.0))
    settings = [one.setting for one in next_after(found, limits)]
    assert settings
    assert all(20.0 <= one.pressure_a_kpa <= 60.0 for one in settings)
    assert all(2.0 <= one.offset_mm <= 10.0 for one in settings)
    assert next_after(found, Limits((1.0, 2.0), (0.0, 1.0))) == ()


def test_next_shots_hold_both_where_the_form_is_most_and_where_it_is_least() -> None:
    data, found = proposed("restitution-bump", 0.008)
    shots = next_after(found)
    assert sum(one.repeat for one in shots) >= 8
    used = {tuple(row) for row in zip(data.covariates["pressure_a_kpa"], strict=True)}
    assert all((one.setting.pressure_a_kpa,) in used for one in shots)
    assert len({one.setting.pressure_a_kpa for one in shots}) > 1


def test_where_nothing_is_proposed_no_shots_are_asked_for() -> None:
    assert next_after(proposed(None)[1]) == ()
