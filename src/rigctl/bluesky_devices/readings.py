"""What a shot is to a run engine: readings with their units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import datetime
from typing import Any

from bluesky.protocols import Reading
from event_model import DataKey

from rigctl.exports.units import RATIO

SETTINGS = {"pressure_a_kpa": "kPa", "pressure_b_kpa": "kPa", "offset_mm": "mm", "delay_us": "us"}
QUANTITIES = {
    **dict.fromkeys(("v_n", "v_s", "v_n_after", "v_s_after"), "m/s"),
    **dict.fromkeys(("e", "beta"), RATIO),
    "contact_duration": "s",
}
WORDS = ("shot", "state")


def described(name: str) -> dict[str, DataKey]:
    """Return the data keys of a device of this name."""
    numbers = {**SETTINGS}
    for quantity, unit in QUANTITIES.items():
        numbers |= {quantity: unit, f"{quantity}_sigma": unit}
    keys = {
        f"{name}_{key}": DataKey(source="rigctl", dtype="number", shape=[], units=unit)
        for key, unit in numbers.items()
    }
    for word in WORDS:
        keys[f"{name}_{word}"] = DataKey(source="rigctl", dtype="string", shape=[])
    return keys


def read_of(name: str, shot: Mapping[str, Any]) -> dict[str, Reading[Any]]:
    """Return the readings of a shot, as `rigctl.firing.measured` gives it.

    What was not measured is NaN. All carry the time at which the shot was fired.
    """
    settings, result = shot["settings"], shot["result"] or {}
    values: dict[str, Any] = {key: _number(settings.get(key)) for key in SETTINGS}
    for quantity in QUANTITIES:
        found = result.get(quantity) or {}
        values[quantity] = _number(found.get("value"))
        values[f"{quantity}_sigma"] = _number(found.get("sigma"))
    values |= {word: str(shot[word]) for word in WORDS}
    fired = datetime.fromisoformat(shot["fired_at"] or shot["accepted_at"]).timestamp()
    return {f"{name}_{key}": Reading(value=v, timestamp=fired) for key, v in values.items()}


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)
