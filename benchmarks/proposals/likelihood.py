"""How often likelihood alone finds a product: what no way of choosing gets beyond by much.

Scores of all forms are drawn as Gaussian about a product that is really there. With its zero off
the shots its arguments by themselves do most of what it does, and among all products one does that
as well by chance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.model.proposals.admissible import admitted
from analysis.model.proposals.channels import Channels
from analysis.model.proposals.forms.form import ContactForm
from analysis.model.proposals.refine import PENALTY
from analysis.model.proposals.rivals import alone
from analysis.model.proposals.screen import columns_of, contact_forms

Floats = NDArray[np.float64]
Group = tuple[str, str]

DRAWS, SET = 400, 3


def found_by_likelihood(channels: Channels, product: ContactForm, d: float, seed: int) -> float:
    """Return the share of draws in which a product is among the three likeliest groups.

    Parameters
    ----------
    channels
        Of a campaign about its fit.
    product
        What is there, its zeros where they are.
    d
        Its strength: standard errors of its amplitude, all that is fitted beside it.
    """
    arguments = admitted(channels.encounter, scalars=False, one_frame=True).arguments
    forms = contact_forms(channels, arguments)
    columns = columns_of(forms)
    weights = [channels.weights(form, number) for form, number in columns]
    mains: dict[tuple[str, tuple[str, str]], int] = {}
    products = [form for form in forms if len(form.arguments) == 2]
    for form in products:
        for place, argument in enumerate(form.arguments):
            key = form.slot, argument.key
            if key not in mains:
                mains[key] = len(weights)
                weights.append(channels.weights(alone(form, place)))
    weights.append(channels.weights(product))
    matrix = channels.summed(weights).matrix
    values, vectors = np.linalg.eigh(matrix)
    noise = np.random.default_rng(seed).standard_normal((len(matrix), DRAWS))
    drawn = (vectors * np.sqrt(values.clip(min=0.0))) @ noise
    drawn += (matrix[:, -1] * d / np.sqrt(matrix[-1, -1]))[:, None]
    best: dict[Group, Floats] = {}
    start = 0
    for form in forms:
        rows = [*range(start, start + len(form.symbols))]
        start += len(form.symbols)
        sought = len(rows) - 1
        if len(form.arguments) == 2:
            rows += [mains[form.slot, argument.key] for argument in form.arguments]
            sought = 2
        elif form.free:
            sought += len(form.free)
        worth = _falls(matrix, drawn, rows) - PENALTY * sought
        best[form.group] = np.maximum(best.get(form.group, -np.inf), worth)
    others = np.stack([*best.values()])
    return float(((others > best[product.group]).sum(axis=0) < SET).mean())


def _falls(matrix: Floats, drawn: Floats, rows: list[int]) -> Floats:
    """Return by how much chi-squared falls with some columns, shape (draws,)."""
    block = matrix[np.ix_(rows, rows)]
    return np.asarray((drawn[rows] * (np.linalg.pinv(block, 1e-10) @ drawn[rows])).sum(axis=0))
