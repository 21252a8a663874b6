"""Drag of a ball that bounces, from its flights alone, before any law of contact sees it.

Beside a law that is far off, the drag would make up for what the law misses: restitution that
depends on speed looks like air. Straight parabolas are fitted to both flights of every bounce, and
one coefficient to what they leave.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np

from analysis.collision.operator import WaltonLaw
from analysis.effects.flight.drag import EFFECT as DRAG
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, PoseStream
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.noise import about_free_flight
from analysis.model.fitting.systematics import Systematic
from analysis.model.predict.columns import systematic_columns
from analysis.model.predict.comparison import compare
from analysis.model.predict.start import first_states
from analysis.model.predict.theory import LAW_PRIOR, Theory

C = TypeVar("C", PoseData, ContactTable, PoseStream, Data, CampaignData)

ROUNDS = 2
LEAST_SIGMA = 1e-6
"""Of a coefficient that is stated without error."""
WIDER = 1.5
"""By which the scatter about flights, and what is not linear in them, enlarges the error."""


def with_measured_air(data: C) -> C:
    """Return a campaign on a plate with the drag that its flights have; others as they are."""
    if isinstance(data, ContactTable) or not data.bodies[1].is_plate:
        return data
    stated = next(s for s in data.systematics if s.effect is DRAG)
    for _ in range(ROUNDS):
        coefficient, sigma = _measured(data, stated)
        change = partial(replace, drag_coefficient=coefficient, drag_sigma=sigma)
        data = data.changed(change) if isinstance(data, PoseStream) else change(data)
    return data


def _measured(data: PoseData | PoseStream, stated: Systematic) -> tuple[float, float]:
    """Return the drag coefficient of all flights and of what is stated, and its standard error."""
    here = next(s for s in data.systematics if s.effect is DRAG)
    about = Theory(WaltonLaw(*LAW_PRIOR), (here,))
    information, pull, chi2, freedom = 0.0, 0.0, 0.0, 0.0
    for part in data.parts():
        states = first_states(part)
        line, predicted = compare(part, states, about)
        free = about_free_flight(line)
        column = systematic_columns(part, states, about, line, predicted).frames
        across = column - free.basis @ (np.swapaxes(free.basis, 2, 3) @ column)
        information += float((across**2).sum())
        pull += float((across[..., 0] * free.left).sum())
        chi2 += float((free.left**2).sum())
        freedom += float(free.share.sum())
    left = chi2 - (pull**2 / information if information > 0 else 0.0)
    noise = max(WIDER * left / max(freedom - 1.0, 1.0), 1e-12)
    prior = max(stated.sigma, LEAST_SIGMA) ** -2
    whole = information / noise + prior
    back = float(stated.values[0] - here.values[0]) * prior
    return float(here.values[0]) + (pull / noise + back) / whole, whole**-0.5
