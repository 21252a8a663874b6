"""A proposal written to a file is the effect that was fitted."""

from __future__ import annotations

import ast
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from analysis.collision.operator import walton
from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import ContactEffect
from analysis.effects.own.loading import load_effects
from analysis.model.fitting.robust_fit import robust_fit
from analysis.model.proposals.arguments import known_arguments
from analysis.model.proposals.effect_file import (
    effect_name,
    origin,
    text_of,
    written,
)
from analysis.model.proposals.forms.form import SLOTS, ContactForm
from analysis.model.proposals.forms.shapes import LINEAR, Spread
from analysis.model.proposals.proposed import Accepted
from analysis.model.proposals.screen import shapes_of
from analysis.model.proposals.stated import Origin
from tests.unit.analysis.model.proposals.hidden import proposed


@pytest.mark.parametrize(
    ("name", "amplitude"),
    [
        pytest.param("restitution-bump", 0.008, marks=pytest.mark.long),
        ("restitution-warm-and-fast", 0.004),
        ("attraction-power", 10.0),
        pytest.param("restitution-step", 0.008, marks=pytest.mark.long),
    ],
)
def test_a_written_file_loads_and_fits_the_shots_as_the_proposal_did(
    tmp_path: Path, name: str, amplitude: float
) -> None:
    data, found = proposed(name, amplitude)
    paths = written(tmp_path, "nylon", found)
    assert len(paths) == len(found.accepted)
    loaded = load_effects(tmp_path, CATALOGUE)
    assert loaded.faults == ()
    beside = [effect for effect in CATALOGUE if effect.name in found.effects]
    again = robust_fit(data, [*beside, *loaded.effects])
    assert again.fit.chi2 == pytest.approx(found.fit.chi2, abs=0.1)


def test_a_file_says_from_which_shots_it_comes(tmp_path: Path) -> None:
    data, found = proposed("restitution-bump", 0.008)
    [path] = written(tmp_path, "nylon's own", found)
    assert origin(path) == Origin("nylon's own", f"1-{len(data.shots)}")


def forms() -> list[ContactForm]:
    """Return every slot with every argument in every shape, and products."""
    _, found = proposed(None)
    encounter = found.encounter
    arguments = known_arguments(encounter, scalars=False, one_frame=True)
    made = []
    for k, argument in enumerate(arguments):
        slot = SLOTS[k % len(SLOTS)]
        if not argument.is_scalar:
            ones = (1.0,) * len(argument.codes)
            made.append(ContactForm(slot, (argument,), None, (), ones))
            continue
        values = argument.of(encounter)[:, 0]
        spread = Spread(float(values.min()), float(values.max()), float(values.mean()))
        for shape in shapes_of(argument):
            constants, ones = shape.grid(spread, 1)[0], (1.0,) * len(shape.codes)
            made.append(ContactForm(slot, (argument,), shape, constants, ones))
    scalars = [argument for argument in arguments if argument.is_scalar]
    made += [ContactForm(slot, (arguments[0],), LINEAR, (2.0,), (1.0,)) for slot in SLOTS]
    made += [ContactForm("e", (a, b), None, (1.3, 2.7), (1.0,)) for a, b in pairwise(scalars)]
    return made


def test_the_file_of_every_form_does_what_the_form_does() -> None:
    _, found = proposed("restitution-bump", 0.008)
    made = forms()
    assert len({effect_name(form) for form in made}) > 40
    for form in made:
        effect = effect_of_file(found.accepted[0], form)
        values = 0.01 * np.arange(1, len(form.symbols) + 1)
        by_form = form.effect("x").wrap(walton, values)(found.encounter).after
        by_file = effect.wrap(walton, values)(found.encounter).after
        for name in ("velocity_a", "velocity_b", "spin_a", "spin_b"):
            one, other = getattr(by_file, name), getattr(by_form, name)
            close = 1e-12 * np.abs(other).max()
            np.testing.assert_allclose(one, other, rtol=0, atol=close, err_msg=effect_name(form))


def effect_of_file(one: Accepted, form: ContactForm) -> ContactEffect:
    """Return the effect of the file that is written for a form."""
    accepted = replace(one, found=replace(one.found, scored=replace(one.found.scored, form=form)))
    text = text_of(accepted, Origin("nylon", "1", ("lasting-contact",)))
    ast.parse(text)
    scope: dict[str, object] = {}
    exec(compile(text, "proposal.py", "exec"), scope)
    effect = scope["EFFECT"]
    assert isinstance(effect, ContactEffect)
    return effect
