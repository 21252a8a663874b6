"""Next shots as other programs read them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from analysis.model.design.between import Repeated, Telling
from analysis.model.design.sharpen import Sharpening

Json = dict[str, Any]

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
    """Return settings and how often to fire each."""
    return [
        {
            "pressure_a_kpa": one.setting.pressure_a_kpa,
            "pressure_b_kpa": one.setting.pressure_b_kpa,
            "offset_mm": one.setting.offset_mm,
            "repeat": one.repeat,
        }
        for one in shots
    ]
