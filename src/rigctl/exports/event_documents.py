"""A campaign as documents of the event model: start, descriptors, an event a shot, stop.

What tools of the Bluesky project read (D. Allan, T. Caswell, S. Campbell and M. Rakitin,
Synchrotron Radiation News 32 (3), 19 (2019)). Identifiers are made of the hashes of what was
measured: the same measurements give the same documents, and a changed one gives others.
"""

from __future__ import annotations

import json
import uuid
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.results.campaign import Results
from analysis.results.impacts import V_N, V_N_AFTER, V_S, V_S_AFTER
from analysis.results.ratios import Ratio, velocities
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError, StoreError
from rigctl.reports.source import Source
from rigctl.units import RATIO, unit_of

Document = tuple[str, Json]

SPACE = uuid.UUID("6f1c1d4e-5b0f-5a55-9d0c-3f6f5f0e8486")
"""Identifiers are made below this one."""
NORMAL, SURFACE = "primary", "surface"
"""Streams: what every impact has, and what those with measured spins have besides."""


@dataclass(frozen=True, slots=True, eq=False)
class Column:
    """A number of each event: its name, unit and values, shape (S,)."""

    name: str
    unit: str
    values: Floats | NDArray[np.intp]


def campaign_documents(source: Source, found: Results) -> Iterator[Document]:
    """Give the documents of a campaign in their order, each with its kind.

    Numbers are settings, velocities and coefficients, `x_sigma` the standard error of `x`, and
    `x_sigma_own` and `x_sigma_common` its parts: the shot's own, and what all share. A shot that
    was left out has no event and is named in the start document. No number is NaN.

    Raises
    ------
    AnalysisInputError
        A shot has no time.
    """
    rows = _by_time(source, found)
    times = [source.fired[int(found.impacts.shots[row])].timestamp() for row in rows]
    left_out = [(one.shot, one.reason) for one in (*source.missing, *found.left_out, *found.far)]
    behind = [version("rigctl"), source.title, source.files, left_out]
    run = uuid.uuid5(SPACE, json.dumps(behind))
    yield "start", _start(source, found, run, times[0])
    counts = {}
    for stream, columns in (
        (NORMAL, [*_settings(source, found), *_normal(found)]),
        (SURFACE, _surface(found)),
    ):
        seen = [
            (row, time)
            for row, time in zip(rows, times, strict=True)
            if all(np.isfinite(column.values[row]) for column in columns)
        ]
        if seen:
            yield from _stream(run, stream, columns, seen)
        counts[stream] = len(seen)
    yield (
        "stop",
        {
            "uid": _name(run, "stop"),
            "run_start": str(run),
            "time": times[-1],
            "exit_status": "success",
            "reason": "",
            "num_events": {stream: count for stream, count in counts.items() if count},
        },
    )


def write_documents(path: Path, source: Source, found: Results) -> None:
    """Write the documents as lines of JSON, [kind, document] each; a file there is not replaced.

    Raises
    ------
    AnalysisInputError
        A shot has no time.
    StoreError
        The file is there, or cannot be written.
    """
    documents = list(campaign_documents(source, found))
    try:
        with path.open("x", encoding="utf-8") as file:
            for document in documents:
                file.write(json.dumps(document, allow_nan=False) + "\n")
    except FileExistsError as error:
        raise StoreError("is there already", part=str(path), todo="choose another name") from error
    except OSError as error:
        raise StoreError(
            f"cannot be written: {error.strerror or error}",
            part=str(path),
            todo="free the disk, or choose another place",
        ) from error


def _by_time(source: Source, found: Results) -> list[int]:
    """Return the rows of the impacts in the order of firing."""
    shots = [int(shot) for shot in found.impacts.shots]
    if untimed := [shot for shot in shots if shot not in source.fired]:
        raise AnalysisInputError(
            "has no time, which every event needs",
            part=f"{source.origin}, shot {untimed[0]}",
            todo="fill the column time of shots.csv",
        )
    return sorted(range(len(shots)), key=lambda row: (source.fired[shots[row]], shots[row]))


def _start(source: Source, found: Results, run: uuid.UUID, time: float) -> Json:
    left_out = [*source.missing, *found.left_out, *found.far]
    return {
        "uid": str(run),
        "time": time,
        "plan_name": "campaign",
        "campaign": source.title,
        "simulated": source.simulated,
        "program": {"name": "rigctl", "version": version("rigctl")},
        "detectors": ["rig"],
        "hints": {"dimensions": [[["approach_speed"], NORMAL]]},
        "left_out": [{"shot": one.shot, "reason": one.reason} for one in left_out],
        "files": [{"file": name, "sha256": digest} for name, digest in source.files],
        "apparatus": {facts.heading: dict(facts.rows) for facts in source.facts},
    }


def _stream(
    run: uuid.UUID, stream: str, columns: Sequence[Column], seen: Sequence[tuple[int, float]]
) -> Iterator[Document]:
    descriptor = _name(run, stream)
    names = [column.name for column in columns]
    yield (
        "descriptor",
        {
            "uid": descriptor,
            "run_start": str(run),
            "time": seen[0][1],
            "name": stream,
            "data_keys": {column.name: _key(column) for column in columns},
            "object_keys": {"rig": names},
            "configuration": {"rig": {"data": {}, "data_keys": {}, "timestamps": {}}},
            "hints": {"rig": {"fields": [name for name in ("e", "beta") if name in names]}},
        },
    )
    for number, (row, time) in enumerate(seen, start=1):
        yield (
            "event",
            {
                "uid": _name(run, f"{stream} {number}"),
                "descriptor": descriptor,
                "seq_num": number,
                "time": time,
                "data": {column.name: _plain(column, row) for column in columns},
                "timestamps": dict.fromkeys(names, time),
                "filled": {},
            },
        )


def _key(column: Column) -> Json:
    kind = "integer" if column.values.dtype.kind == "i" else "number"
    return {
        "dtype": kind,
        "dtype_numpy": column.values.dtype.str,
        "shape": [],
        "source": "rigctl",
        "units": column.unit,
        "object_name": "rig",
    }


def _plain(column: Column, row: int) -> float | int:
    value: float | int = column.values[row].item()
    return value


def _settings(source: Source, found: Results) -> list[Column]:
    place = {int(shot): row for row, shot in enumerate(source.data.shots)}
    rows = [place[int(shot)] for shot in found.impacts.shots]
    settings = sorted(source.data.covariates.items())
    return [
        Column("shot", RATIO, found.impacts.shots),
        *(Column(name, unit_of(name), values[rows]) for name, values in settings),
    ]


def _normal(found: Results) -> list[Column]:
    each = found.ratios
    return [
        Column("approach_speed", "m/s", found.impacts.approach),
        *_velocity(found, "v_n", V_N),
        *_velocity(found, "v_n_after", V_N_AFTER),
        *_with_parts("e", RATIO, each.e),
    ]


def _surface(found: Results) -> list[Column]:
    each = found.ratios
    return [
        Column("surface_shot", RATIO, found.impacts.shots),
        *_velocity(found, "v_s", V_S),
        *_velocity(found, "v_s_after", V_S_AFTER),
        *_with_parts("beta", RATIO, each.beta),
        *_with_parts("f", RATIO, each.f),
        Column("probability_of_sliding", RATIO, found.lines.held.slides),
    ]


def _velocity(found: Results, name: str, column: int) -> list[Column]:
    return _with_parts(name, "m/s", velocities(found.impacts)[column])


def _with_parts(name: str, unit: str, ratio: Ratio) -> list[Column]:
    """Return value and error, and the error's own and shared parts where they are separated."""
    whole = [Column(name, unit, ratio.value), Column(f"{name}_sigma", unit, ratio.sigma)]
    if np.isnan(ratio.common).all():
        return whole
    own = Column(f"{name}_sigma_own", unit, ratio.own)
    return [*whole, own, Column(f"{name}_sigma_common", unit, ratio.common)]


def _name(run: uuid.UUID, part: str) -> str:
    return str(uuid.uuid5(run, part))
