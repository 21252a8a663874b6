"""From the options of `rigctl sweep` to the form of a sweep."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rigctl.config.loading import checked
from rigctl.errors import ConfigurationError, SettingsError
from rigctl.sweeps.form import Sweep, read_sweep

Json = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Options:
    """A sweep as the command line has it: a file, or ranges in its place.

    `pressure_kpa`, `pressure_b_kpa` and `offset_mm` are `A:B:N` or lists `A,B,C`; `until` is
    `NAME=SIGMA`.
    """

    file: Path | None
    pressure_kpa: str | None
    pressure_b_kpa: str | None
    offset_mm: str | None
    repeat: int
    shuffle: bool
    seed: int
    settle_s: float
    pause_s: float
    until: str | None
    adaptive: bool
    campaign: str | None


def form_of(options: Options) -> Sweep:
    """Return the sweep that the options ask for.

    Raises
    ------
    ConfigurationError, SettingsError
        The file cannot be; neither file nor ranges are given, or both; or a range cannot be.
    """
    ranges = (options.pressure_kpa, options.pressure_b_kpa, options.offset_mm)
    if options.file is not None:
        if any(text is not None for text in ranges):
            raise ConfigurationError(
                "a sweep is given by a file or by ranges, not by both",
                part=str(options.file),
                todo="leave one of them out",
            )
        return read_sweep(options.file)
    if options.pressure_kpa is None or options.offset_mm is None:
        raise ConfigurationError(
            "a sweep needs a file, or --pressure-kpa and --offset-mm", todo="give one of them"
        )
    grid: Json = {
        "pressure_a_kpa": _levels("--pressure-kpa", options.pressure_kpa),
        "offset_mm": _levels("--offset-mm", options.offset_mm),
    }
    if options.pressure_b_kpa is not None:
        grid["pressure_b_kpa"] = _levels("--pressure-b-kpa", options.pressure_b_kpa)
    document: Json = {
        "repeat": options.repeat,
        "shuffle": options.shuffle,
        "seed": options.seed,
        "settle_s": options.settle_s,
        "pause_s": options.pause_s,
        "grid": grid,
    }
    if options.campaign is not None:
        document["campaign"] = options.campaign
    if options.until is not None:
        document["until"] = _until(options.until) | {"adaptive": options.adaptive}
    elif options.adaptive:
        raise SettingsError("has no aim", part="--adaptive", todo="say --until NAME=SIGMA")
    return checked(Sweep, document, "rigctl sweep")


def _levels(option: str, text: str) -> list[float] | Json:
    """Return the values that `A:B:N`, `A,B,C` or `A` stands for."""
    try:
        if ":" not in text:
            return [float(part) for part in text.split(",")]
        first, last, count = text.split(":")
        if int(count) == 1 and float(first) == float(last):
            return [float(first)]
        return {"first": float(first), "last": float(last), "count": int(count)}
    except ValueError as error:
        raise SettingsError(
            "is neither a range nor a list of numbers",
            part=option,
            value=repr(text),
            limit="A:B:N (N values from A to B), or A,B,C",
            todo="write it so",
        ) from error


def _until(text: str) -> Json:
    name, _, sigma = text.partition("=")
    try:
        return {"coefficient": name, "sigma": float(sigma)}
    except ValueError as error:
        raise SettingsError(
            "names no standard error",
            part="--until",
            value=repr(text),
            limit="NAME=SIGMA, such as e=0.001",
            todo="write it so",
        ) from error
