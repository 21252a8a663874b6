"""Findings that slow errors of the images make as well.

An outline's or a pattern's offset is stated with the slow errors of the images, and is in every
fit as large as that. Freed of it, it follows whatever the images do along a flight: what moves the
places of the spheres by no more than slow errors do is theirs, as in the cells of the heat map.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.systematics import OF_IMAGES
from analysis.model.predict.theory import Theory
from analysis.model.rank.candidate import Candidate

_NAMES = frozenset(effect.name for effect in OF_IMAGES)


def with_places_moved(
    candidates: list[Candidate], data: CampaignData, theory: Theory, scale: float
) -> list[Candidate]:
    """Say of errors of images that are stated by how much they move places, and whether it counts.

    A fall is the sum of squares of what is moved over its standard error, so that root mean
    square, places weighted with their errors, at most sqrt(fall / sum of 1/sigma^2) is moved: the
    lines through the flights have a part in the fall, and no part in what moves beside them.

    Parameters
    ----------
    scale
        Root of chi-squared per degree of freedom, in which falls are counted.
    """
    stated = {s.effect.name for s in theory.systematics} & _NAMES
    if not stated or isinstance(data, ContactTable):
        return candidates
    weight = 0.0
    for part in data.parts():
        assert not isinstance(part, ContactTable)  # noqa: S101
        weight += float((part.position_sigma[np.isfinite(part.position_sigma)] ** -2).sum())
    limit = data.slow.between_m
    marked = []
    for one in candidates:
        moved = scale * float(np.sqrt(one.delta_chi2 / weight))
        known = one.seen and one.effect.name in stated
        marked.append(replace(one, moved_m=moved, of_measurement=moved < limit) if known else one)
    return marked
