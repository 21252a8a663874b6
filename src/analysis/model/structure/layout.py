"""How cells of structure are laid out and labelled, whatever draws them: rows, columns, words.

Loads nothing of the model: the page starts without it.
"""

from __future__ import annotations

from collections.abc import Iterable

from analysis.model.structure.findings import ALWAYS

ALARM = 0.01
"""Chance with all cells looked at below which a cell is framed."""
BRIGHTEST = 12.0
"""The darkest colour stands for so many standard deviations at least."""
AXES = ("n", "t", "b")
CHANNELS = tuple(
    f"{word} {kind} {axis}"
    for kind in ("velocity", "spin", "position", "orientation")
    for word in ("relative", "common")
    for axis in AXES
)
LABELS = {
    "ln v_n": "ln(v_n / (m/s)), approach speed before contact",
    "ln v_s/v_n": "ln(v_s / v_n), surface speed over approach speed",
    "spin along v_t x n": "spin along v_t × n, rad/s",
    "spin about n": "relative spin about n, rad/s",
    "contact X": "contact at X, m",
    "contact Y": "contact at Y, m",
    "contact Z": "contact at Z, m",
    "order": "order of firing, first to last",
    "time": "time from contact, s",
    "field X": "position X in the field, m",
    "field Y": "position Y in the field, m",
    "field Z": "position Z in the field, m",
}
_UNITS = {"kpa": "kPa", "mm": "mm", "us": "µs", "c": "°C", "s": "s", "m": "m", "deg": "°"}


def covariate_label(name: str) -> str:
    """Return a covariate with its unit, for the axis of a picture.

    The unit of a column of the shot list is the last word of its name, as in `offset_mm`.
    """
    if name in LABELS:
        return LABELS[name]
    words, _, unit = name.rpartition("_")
    if words and unit in _UNITS:
        return f"{words.replace('_', ' ')}, {_UNITS[unit]}"
    return name.replace("_", " ")


def short_label(covariate: str) -> str:
    """Return a covariate as it stands at a column."""
    if covariate in (*LABELS, ALWAYS):
        return covariate.replace(" x ", " × ")
    return covariate_label(covariate)


def rows_of(channels: Iterable[str]) -> list[str]:
    """Return channels once each, in an order that does not depend on the data."""
    return _in_order(channels, CHANNELS)


def columns_of(covariates: Iterable[str]) -> list[str]:
    """Return covariates once each, the mean of each row first."""
    return _in_order(covariates, (ALWAYS, *LABELS))


def _in_order(names: Iterable[str], known: tuple[str, ...]) -> list[str]:
    there = set(names)
    return [*(name for name in known if name in there), *sorted(there - set(known))]
