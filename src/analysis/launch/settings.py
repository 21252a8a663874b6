"""Settings of each shot, and of the shots before it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.errors import InputError, LaunchRefusedError
from analysis.exchange.shot_list import ShotRow, read_shot_list
from analysis.model.data.poses import Observations

PRESSURES, OFFSET, DELAY, WAITED = (
    ("pressure_a_kpa", "pressure_b_kpa"),
    "offset_mm",
    "delay_us",
    "wait_s",
)


@dataclass(frozen=True, slots=True, eq=False)
class LaunchSettings:
    """Settings of S shots, and the little of their history that a launch may remember.

    Attributes
    ----------
    pressure_kpa
        Gauge pressures of a and b, shape (S, 2).
    offset_m
        Track b below track a, shape (S,).
    delay_s
        Pusher b after pusher a, shape (S,).
    pressure_step, slide_step
        Sign of the last change of each pressure, (S, 2), and of the last move of the slide, (S,);
        zero before the first.
    waited_s
        Time from the charging to the pulse, shape (S,); zero where it is not known.
    """

    pressure_kpa: Floats
    offset_m: Floats
    delay_s: Floats
    pressure_step: Floats
    slide_step: Floats
    waited_s: Floats

    @property
    def charge(self) -> dict[str, Floats]:
        """All fields by name."""
        return {name: getattr(self, name) for name in self.__slots__}

    def of_shots(self, chosen: NDArray[np.bool_] | NDArray[np.intp]) -> LaunchSettings:
        """Return the settings of some shots, by mask or index."""
        return replace(self, **{name: values[chosen] for name, values in self.charge.items()})


def in_turn(
    pressure_kpa: Floats,
    offset_m: Floats,
    *,
    delay_s: Floats | None = None,
    waited_s: Floats | None = None,
) -> LaunchSettings:
    """Return settings of shots fired one after another, shapes (S, 2) and (S,).

    A setting that stays keeps the direction it was reached from.
    """
    none = np.zeros(len(offset_m))
    return LaunchSettings(
        pressure_kpa=pressure_kpa,
        offset_m=offset_m,
        delay_s=none if delay_s is None else delay_s,
        pressure_step=np.stack([_directions(p) for p in pressure_kpa.T], axis=1),
        slide_step=_directions(offset_m),
        waited_s=none if waited_s is None else waited_s,
    )


def settings_of(data: Observations) -> LaunchSettings:
    """Return the settings that the covariates of a campaign hold, shots in the order of firing.

    Raises
    ------
    LaunchRefusedError
        Pressures or offset are not known of all shots.
    """
    known = data.covariates
    if missing := [name for name in (*PRESSURES, OFFSET) if name not in known]:
        raise LaunchRefusedError(f"settings that not all shots have: {', '.join(missing)}")
    firing = np.argsort(known["order"], kind="stable")
    none = np.zeros(len(firing))
    ordered = in_turn(
        np.stack([known[name][firing] for name in PRESSURES], axis=1),
        known[OFFSET][firing] * 1e-3,
        delay_s=known.get(DELAY, none)[firing] * 1e-6,
        waited_s=known.get(WAITED, none)[firing],
    )
    return ordered.of_shots(np.argsort(firing))


def read_settings(path: Path, shots: NDArray[np.intp]) -> LaunchSettings:
    """Read the settings of some shots from shots.csv, with what was fired between them.

    Shots that were not measured count in the history if their settings are there. The column
    `wait_s` holds the time from the charging to the pulse; without it, it is the time since the
    shot before, as the next charge then begins.

    Raises
    ------
    InputError
        The list cannot be read, or a shot has no pressure or no offset.
    """
    rows = read_shot_list(path)
    if all(row.time is not None for row in rows):
        rows.sort(key=_fired)
    for row in rows:
        if row.shot in shots and (missing := _missing(row)):
            raise InputError(path, f"shot {row.shot} has no {', '.join(missing)}")
    rows = [row for row in rows if not _missing(row)]
    every = in_turn(
        np.array([[row.numbers[name] for name in PRESSURES] for row in rows]).reshape(-1, 2),
        np.array([row.numbers[OFFSET] for row in rows]) * 1e-3,
        delay_s=np.array([row.numbers.get(DELAY, 0.0) for row in rows]) * 1e-6,
        waited_s=_waited(rows),
    )
    place = {row.shot: k for k, row in enumerate(rows)}
    if unlisted := [int(shot) for shot in shots if int(shot) not in place]:
        raise InputError(path, f"shots that have poses stand in no row: {unlisted}")
    return every.of_shots(np.array([place[int(shot)] for shot in shots], dtype=np.intp))


def _missing(row: ShotRow) -> list[str]:
    return [name for name in (*PRESSURES, OFFSET) if name not in row.numbers]


def _fired(row: ShotRow) -> float:
    return 0.0 if row.time is None else row.time.timestamp()


def _waited(rows: Sequence[ShotRow]) -> Floats:
    """Return the waiting time of each shot, s; of the first, where only times are known, zero."""
    if all(WAITED in row.numbers for row in rows):
        return np.array([row.numbers[WAITED] for row in rows])
    times = np.array([_fired(row) for row in rows])
    return np.diff(times, prepend=times[:1])


def _directions(values: Floats) -> Floats:
    """Return the sign of the last change up to each place, zero before the first, shape (S,)."""
    signs = np.sign(np.diff(values, prepend=values[:1]))
    last = np.maximum.accumulate(np.where(signs != 0, np.arange(len(signs)), 0))
    return np.asarray(signs[last])
