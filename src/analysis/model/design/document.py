"""Next shots as other programs read them."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.model.design.between import Repeated, Telling
from analysis.model.design.sharpen import Sharpening
from analysis.schema.codec import Json, written
from analysis.schema.verdict import NextShot

NONE = "none"
"""What the base model is called where an effect could stand."""


def telling_document(found: Telling) -> Json:
    """Return shots that tell two effects apart."""
    return {
        "between": [name or NONE for name in found.between],
        "probability": found.probability,
        "probability_each": found.each,
        "probability_without": found.without,
        "enough": found.enough,
        "shots": found.count,
        "even_shots": found.even,
        "next_shots": shots_document(found.shots),
    }


def sharpening_document(found: Sharpening) -> Json:
    """Return shots that sharpen a parameter."""
    return {
        "sharpen": found.parameter,
        "unit": found.unit,
        "sigma_without": found.present,
        "to": found.target,
        "sigma": found.reached,
        "enough": found.enough,
        "shots": found.count,
        "even_shots": found.even,
        "next_shots": shots_document(found.shots),
    }


def shots_document(shots: Sequence[Repeated]) -> list[Json]:
    """Return the JSON of settings and how often to fire each."""
    return [written(shot) for shot in next_shots(shots)]


def next_shots(shots: Sequence[Repeated]) -> tuple[NextShot, ...]:
    """Return settings and how often to fire each."""
    settings = ((one.setting, one.repeat) for one in shots)
    return tuple(NextShot(s.pressure_a_kpa, s.pressure_b_kpa, s.offset_mm, n) for s, n in settings)
