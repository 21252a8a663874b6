"""Products of two arguments whose zeros lie where the shots want them.

a (x - x0) (y - y0) is a x y + b x + c y beside a constant: three columns say how far chi-squared
falls with both zeros free. About the means of the shots the product alone may say little, where a
law as T ln(v_n / (1 m/s)) acts mostly through one argument.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis.arrays import Floats
from analysis.model.proposals.arguments import Argument
from analysis.model.proposals.channels import Channels, Form
from analysis.model.proposals.forms.form import ContactForm
from analysis.model.proposals.forms.shapes import LINEAR, POWER
from analysis.model.proposals.refine import ScoredForm

FARTHEST = 20.0
"""Of a zero from the mean of the shots, in their standard deviations: beyond it one argument is as
good as alone."""


def freed_products(channels: Channels, forms: Sequence[Form]) -> list[ScoredForm]:
    """Return every product at its likeliest zeros, the most worth first."""
    products = [f for f in forms if isinstance(f, ContactForm) and len(f.arguments) == 2]
    if not products:
        return []
    mains = {
        (form.slot, argument.key): alone(form, place)
        for form in products
        for place, argument in enumerate(form.arguments)
    }
    columns: list[ContactForm] = [*products, *mains.values()]
    sums = channels.summed([channels.weights(form) for form in columns])
    places = {key: len(products) + k for k, key in enumerate(mains)}
    found = []
    for k, form in enumerate(products):
        rows = np.array([k, *(places[form.slot, a.key] for a in form.arguments)])
        if not sums.seen[rows].all():
            continue
        block = sums.of(rows)
        solved: Floats = np.asarray(
            np.linalg.lstsq(block.matrix, block.gradient, rcond=1e-10)[0], np.float64
        )
        moved = _at_zeros(form, solved, channels)
        if moved is not None:
            delta_chi2 = float(block.gradient @ solved) / channels.noise_scale**2
            found.append(ScoredForm(moved, delta_chi2, solved[:1], 0.0, zeros_sought=True))
    return sorted(found, key=lambda scored: -scored.worth)


def main_groups(form: Form) -> set[tuple[str, str]]:
    """Return what a product says where one of its arguments does not change."""
    arguments: tuple[Argument, ...] = form.arguments if isinstance(form, ContactForm) else ()
    return {(form.slot, argument.name) for argument in arguments}


def alone(form: ContactForm, place: int) -> ContactForm:
    """Return one argument of a product by itself, with the zero that it has in the product."""
    argument, zero = form.arguments[place], form.constants[place]
    shape = POWER if argument.positive else LINEAR
    return ContactForm(form.slot, (argument,), shape, (zero,), (1.0,))


def _at_zeros(form: ContactForm, solved: Floats, channels: Channels) -> ContactForm | None:
    """Return a product with its zeros where a fit of three columns has them; None: too far off."""
    both, first, second = (float(value) for value in solved)
    if both == 0.0:
        return None
    zeros = []
    for argument, zero, other in zip(form.arguments, form.constants, (second, first), strict=True):
        way = -other / both
        numbers = argument.of(channels.encounter)[:, 0]
        spread = np.log(np.maximum(numbers, 1e-9)).std() if argument.positive else numbers.std()
        if abs(way) > FARTHEST * float(spread):
            return None
        zeros.append(zero * float(np.exp(way)) if argument.positive else zero + way)
    moved = form.at(*zeros)
    largest = float(np.abs(moved.columns(channels.encounter)).max())
    return ContactForm(form.slot, form.arguments, form.shape, moved.constants, (largest,))
