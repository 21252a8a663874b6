"""A form stated as numbers and names is the same form again, and is tested on other shots."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from analysis.errors import ProposalRefusedError
from analysis.model.proposals.arguments import known_arguments
from analysis.model.proposals.channels import Form
from analysis.model.proposals.confirm import confirm_stated
from analysis.model.proposals.effect_file import written
from analysis.model.proposals.forms.flight import flight_forms
from analysis.model.proposals.forms.form import SLOTS, ContactForm
from analysis.model.proposals.forms.frame import frame_forms
from analysis.model.proposals.forms.shapes import LINEAR, POWER, spread_of
from analysis.model.proposals.screen import shapes_of
from analysis.model.proposals.stated import (
    Origin,
    Statement,
    numbers_among,
    read_statement,
)
from analysis.motion.frame_notes import ranges
from tests.unit.analysis.model.proposals.hidden import campaign, proposed
from tests.unit.analysis.model.proposals.test_launch_search import warm, with_warm_pushers


def again(form: Form) -> Form:
    """Return a form after it was written as JSON and read."""
    data, _ = proposed(None)
    text = json.dumps(Statement.of(form, Origin("nylon", "1-3", ("drag",))).document())
    return Statement.read(json.loads(text)).form(data)


def contact_forms() -> list[ContactForm]:
    """Return slots with every argument in every shape, and products."""
    _, found = proposed(None)
    arguments = known_arguments(found.encounter, scalars=False, one_frame=True)
    made = []
    for argument in arguments:
        if not argument.is_scalar:
            ones = (1.0,) * len(argument.codes)
            made.append(ContactForm("mu", (argument,), None, (), ones))
            continue
        spread = spread_of(argument.of(found.encounter)[:, 0])
        for shape in {*shapes_of(argument), LINEAR, *((POWER,) if argument.positive else ())}:
            constants = shape.grid(spread, 1)[-1]
            made.append(ContactForm("e", (argument,), shape, constants, (1.0,) * len(shape.codes)))
    scalar = [pair for pair in pairwise(arguments) if all(a.is_scalar for a in pair)]
    made += [ContactForm("mu", pair, None, (1.5, 2.5), (1.0,)) for pair in scalar]
    return [replace(form, slot=SLOTS[k % len(SLOTS)]) for k, form in enumerate(made)]


def test_every_form_of_the_contact_comes_back_with_the_same_columns() -> None:
    _, found = proposed(None)
    forms = contact_forms()
    assert len(forms) > 60
    for form in forms:
        other = again(form)
        assert isinstance(other, ContactForm)
        assert (other.group, other.shape_name, other.unit) == (
            form.group,
            form.shape_name,
            form.unit,
        )
        np.testing.assert_array_equal(other.columns(found.encounter), form.columns(found.encounter))


def test_forces_in_flight_and_errors_of_camera_and_clock_come_back_with_their_constants() -> None:
    data, _ = proposed(None)
    a, b = data.bodies
    for form in (*flight_forms(a.radius + b.radius, a.mass), *frame_forms()):
        other = again(form)
        assert type(other) is type(form)
        assert (other.group, other.kind, other.constants) == (  # type: ignore[union-attr]
            form.group,
            form.kind,
            form.constants,
        )
        assert (getattr(other, "along", 0), getattr(other, "by", 0)) == (
            getattr(form, "along", 0),
            getattr(form, "by", 0),
        )


def test_a_stated_law_is_confirmed_on_shots_that_have_it_and_not_on_shots_that_have_not() -> None:
    _, found = proposed("restitution-bump", 0.008)
    stated = Statement.of(found.accepted[0].form, Origin("first", "1"))
    there = confirm_stated(campaign({"restitution-bump": 0.008}, 99), (), stated)
    assert there.confirmed
    assert abs(there.parameters["a"].value - 0.008) < 5 * there.parameters["a"].sigma
    assert confirm_stated(campaign({}, 51), (), stated).p_value > 1e-4


def test_a_law_of_the_launch_is_written_and_confirmed_on_other_launches(tmp_path: Any) -> None:
    [path] = written(tmp_path, "warm", warm())
    stated = read_statement(path)
    assert (stated.slot, stated.arguments, stated.shots) == (
        "launch",
        ("temperature_c",),
        "1-60",
    )
    there = confirm_stated(with_warm_pushers(campaign({}, 77)), (), stated)
    assert there.confirmed
    assert there.p_value < 1e-6
    chances = [confirm_stated(campaign({}, seed), (), stated).p_value for seed in (78, 79)]
    assert min(chances) > 1e-4


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({"arguments": ["humidity_pct"]}, "humidity_pct, which the form follows, is not known"),
        ({"columns": ["x ** 7"]}, "columns is 'x \\*\\* 7'"),
        ({"constants": [1.0]}, "the form has 2 constants"),
        ({"constants": [1.0, float("nan")]}, "the form has 2 constants"),
        ({"slot": "flight", "kind": "magic"}, "kind is 'magic'"),
        ({"slot": "phlogiston"}, "states no form of phlogiston"),
        ({"constants": 3}, "states no form: constants is 3"),
        ({"constants": ["5"]}, "states no form: constants is"),
        ({"shots": "all of them"}, "states no form: shots is 'all of them'"),
        ({"along": 7}, "states no form: along is 7"),
    ],
)
def test_what_is_no_form_is_refused_with_what_is_wrong(changed: dict[str, Any], why: str) -> None:
    data, found = proposed("restitution-bump", 0.008)
    document = Statement.of(found.accepted[0].form, Origin("first", "1")).document() | changed
    with pytest.raises(ProposalRefusedError, match=why):
        Statement.read(document).form(data)


def test_shots_seen_are_found_among_those_of_a_campaign_however_long_the_list_says_it_is() -> None:
    numbers = np.array([1, 3, 5, 700])
    assert numbers_among("1-3,7,500-999999999", numbers) == {1, 3, 700}
    assert numbers_among("", numbers) == set()
    assert ranges([9, 1, 2, 3, 7, 10]) == "1-3,7,9-10"
