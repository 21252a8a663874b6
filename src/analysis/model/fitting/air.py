"""Drag of a ball that bounces, from its flights alone, before any law of contact sees it.

Beside a law that is far off, the drag would make up for what the law misses: restitution that
depends on speed looks like air. Parabolas are fitted to both flights of every bounce, and one
coefficient to what they leave. The air goes by the square of the speed: each bounce has the
restitution that lines beside it show.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import WaltonLaw
from analysis.effects.flight.drag import EFFECT as DRAG
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, PoseStream
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.noise import about_free_flight
from analysis.model.fitting.systematics import Systematic
from analysis.model.predict.columns import systematic_columns
from analysis.model.predict.comparison import compare
from analysis.model.predict.start import first_restitutions, first_states
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import LAW_PRIOR, Theory

C = TypeVar("C", PoseData, ContactTable, PoseStream, Data, CampaignData)

ROUNDS = 2
ALIKE = 0.01
"""Restitutions of bounces that are taken as one: speeds after them are as exact."""
POSSIBLE = (0.01, 1.0)
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
    information, pull, chi2, freedom = 0.0, 0.0, 0.0, 0.0
    for part, states, about in _near(data, here):
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


def _near(
    data: PoseData | PoseStream, drag: Systematic
) -> Iterator[tuple[PoseData, ShotStates, Theory]]:
    """Go over bounces with the speeds that their flights have on both sides, as free ones fit.

    Lines beside a bounce lead to these: air slows the ball down while they last.
    """
    for part in data.parts():
        states, e = first_states(part), first_restitutions(part)
        for _ in range(ROUNDS):
            flying = np.zeros((part.count, 2, 3))
            for alike, about in _alike(e, drag):
                line, predicted = compare(part.of_shots(alike), states.of_shots(alike), about)
                change = about_free_flight(line).change[:, 0].reshape(-1, 2, 2, 3)
                flying[alike] = predicted.sides.velocity[:, 0] + change[:, :, 1]
            rates = flying @ np.array(part.plate.normal)
            states = replace(states, before=replace(states.before, velocity_a=flying[:, 0]))
            e = -rates[:, 1] / np.maximum(rates[:, 0], 1e-9)
        for alike, about in _alike(e, drag):
            yield part.of_shots(alike), states.of_shots(alike), about


def _alike(e: Floats, drag: Systematic) -> Iterator[tuple[NDArray[np.bool_], Theory]]:
    """Go over groups of bounces of restitutions (S,) that are alike, with the law of these."""
    rounded = np.clip(ALIKE * np.round(e / ALIKE), *POSSIBLE)
    for own in np.unique(rounded):
        yield rounded == own, Theory(WaltonLaw(float(own), *LAW_PRIOR[1:]), (drag,))
