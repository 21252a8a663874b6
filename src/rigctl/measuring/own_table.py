"""A table of impacts that somebody brings: its columns are given a meaning and a unit, row by row.

Rows that cannot be an impact are left out and named with their line. What is left is written as an
exchange folder with impacts.csv.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from analysis.exchange.description import description
from analysis.exchange.impact_table import SIGMAS, ImpactRow
from analysis.exchange.shot_list import ShotRow
from analysis.setup import CameraSetup, Environment, Setup, SphereSetup
from rigctl.errors import AnalysisInputError

MOST_ROWS, MOST_COLUMNS = 20_000, 60
GRAVITY = 9.80665
SPEED, HEIGHT, NUMBER = "speed", "height", "number"
UNITS = {
    SPEED: {
        "m/s": 1.0,
        "cm/s": 1e-2,
        "mm/s": 1e-3,
        "km/h": 1 / 3.6,
        "in/s": 0.0254,
        "ft/s": 0.3048,
    },
    HEIGHT: {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "ft": 0.3048},
    NUMBER: {"": 1.0},
}
"""Units by the kind of a quantity, in SI units."""


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a column may be.

    Attributes
    ----------
    words
        For the select box.
    kind
        Of its units.
    likely
        Names of columns, in lower case without what is no letter, that are probably it.
    """

    words: str
    kind: str
    likely: tuple[str, ...] = ()


NAMES_BEFORE = (
    *("vn", "vbefore", "vin", "before", "approach", "approachspeed", "speedbefore"),
    *("velocitybefore", "impactspeed", "impactvelocity", "incoming"),
)
NAMES_AFTER = (
    *("vnafter", "vafter", "vout", "after", "parting", "partingspeed", "speedafter"),
    *("velocityafter", "rebound", "reboundspeed", "reboundvelocity", "outgoing"),
)
NOT_USED, SETTING = "", "setting"
MEANINGS = {
    NOT_USED: Meaning("not used", NUMBER),
    "v_n": Meaning(
        "approach speed",
        SPEED,
        NAMES_BEFORE,
    ),
    "v_n_after": Meaning(
        "parting speed",
        SPEED,
        NAMES_AFTER,
    ),
    "v_s": Meaning("sliding speed before", SPEED, ("vs", "slidingbefore", "slidingspeed")),
    "v_s_after": Meaning("sliding speed after", SPEED, ("vsafter", "slidingafter")),
    "fall": Meaning("height of the fall", HEIGHT, ("dropheight", "height", "fallheight", "h")),
    "rise": Meaning("height of the rebound", HEIGHT, ("reboundheight", "bounceheight", "rise")),
    "sigma_v_n": Meaning("error of the approach speed", SPEED, ("sigmavn",)),
    "sigma_v_n_after": Meaning("error of the parting speed", SPEED, ("sigmavnafter",)),
    "sigma_v_s": Meaning("error of sliding before", SPEED, ("sigmavs",)),
    "sigma_v_s_after": Meaning("error of sliding after", SPEED, ("sigmavsafter",)),
    SETTING: Meaning("a setting or condition", NUMBER),
}
SIGMA = "sigma_"
BEFORE, AFTER = ("v_n", "fall"), ("v_n_after", "rise")


@dataclass(frozen=True, slots=True)
class Column:
    """The meaning of a column, and its unit."""

    meaning: str = NOT_USED
    unit: str = ""

    @property
    def factor(self) -> float:
        """What one of its units is in SI units."""
        return UNITS[MEANINGS[self.meaning].kind][self.unit]


@dataclass(frozen=True, slots=True)
class Table:
    """Names of the columns, and rows of texts as long; `lines` says where each stands."""

    names: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]

    def guessed(self) -> list[Column]:
        """Return what the columns probably are by their names, each meaning once."""
        taken = set[str]()
        found = []
        for name in self.names:
            plain, unit = _plain(name)
            meaning = next(
                (m for m, about in MEANINGS.items() if m not in taken and plain in about.likely),
                NOT_USED,
            )
            taken.add(meaning)
            units = UNITS[MEANINGS[meaning].kind]
            found.append(Column(meaning, unit if unit in units else next(iter(units))))
        return found


@dataclass(slots=True)
class Converted:
    """Impacts with their settings, and lines that were left out with the reason."""

    impacts: list[ImpactRow] = field(default_factory=list)
    settings: list[Mapping[str, float]] = field(default_factory=list)
    left_out: list[tuple[int, str]] = field(default_factory=list)


def read_table(path: Path) -> Table:
    """Read a table of texts; separators may be commas, semicolons or tabs.

    Raises
    ------
    AnalysisInputError
        It is empty, too large, no text, or a row is longer than the line of names.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise AnalysisInputError(
            "is no text in UTF-8", part=path.name, todo="save the table as CSV once more"
        ) from error
    lines = text.splitlines()
    head = lines[0] if lines else ""
    separator = max("\t;,", key=head.count)
    read = [(n, row) for n, row in enumerate(csv.reader(lines, delimiter=separator), 1) if any(row)]
    if len(read) < 2 or len(read) > MOST_ROWS or len(read[0][1]) > MOST_COLUMNS:
        raise AnalysisInputError(
            "is no table that can be taken",
            part=path.name,
            value=f"{len(read)} lines, {len(read[0][1]) if read else 0} columns",
            limit=f"a line of names and up to {MOST_ROWS} rows of {MOST_COLUMNS} columns",
            todo="save one table as CSV, its first line the names of the columns",
        )
    names = tuple(name.strip() for name in read[0][1])
    for line, row in read[1:]:
        if len(row) > len(names):
            raise AnalysisInputError(
                f"has {len(row)} fields in line {line}, and {len(names)} names of columns",
                part=path.name,
                todo="name every column in the first line",
            )
    rows = tuple((*row, *[""] * (len(names) - len(row))) for _, row in read[1:])
    return Table(names, rows, tuple(line for line, _ in read[1:]))


def convert(table: Table, columns: Sequence[Column]) -> Converted:
    """Return the impacts of a table, rows that cannot be one left out.

    Raises
    ------
    AnalysisInputError
        A meaning stands twice, no column says how fast it was before or after, or both do.
    """
    used = [column.meaning for column in columns if column.meaning not in {NOT_USED, SETTING}]
    twice = next((meaning for meaning in used if used.count(meaning) > 1), None)
    if twice is not None:
        raise AnalysisInputError(
            f"“{MEANINGS[twice].words}” is chosen for two columns", part="the table"
        )
    for side, names in (("before", BEFORE), ("after", AFTER)):
        if sum(meaning in names for meaning in used) != 1:
            words = " or the ".join(MEANINGS[name].words for name in names)
            raise AnalysisInputError(
                f"needs one column that says how fast it was {side} the impact",
                part="the table",
                todo=f"choose one column for the {words}",
            )
    errors = {meaning for meaning in used if meaning.startswith(SIGMA)}
    needed = {SIGMA + meaning for meaning in used if not meaning.startswith(SIGMA)}
    if errors and errors != needed:
        raise AnalysisInputError(
            "needs the errors of all its speeds, or of none",
            part="the table",
            todo="choose a column for the error of each speed, or leave errors out: they are then "
            "estimated from the scatter",
        )
    found = Converted()
    for line, row in zip(table.lines, table.rows, strict=True):
        try:
            _add(found, row, table.names, columns)
        except ValueError as fault:
            found.left_out.append((line, str(fault)))
    return found


def write_table(
    folder: Path, name: str, found: Converted, diameter_m: float, *, plate: bool
) -> None:
    """Write the impacts as an exchange folder.

    Parameters
    ----------
    plate
        Whether a ball bounced on a surface at rest; else two equal balls met.
    """
    b = SphereSetup("b", plate=True) if plate else SphereSetup("b", diameter_m)
    # No film was taken: the fields of the camera are the least that the format allows.
    setup = Setup(
        camera=CameraSetup(1.0, 8, 8),
        spheres=(SphereSetup("a", diameter_m), b),
        environment=Environment(),
    )
    rows = [
        ShotRow(impact.shot, None, dict(settings), {})
        for impact, settings in zip(found.impacts, found.settings, strict=True)
    ]
    from analysis.exchange.folder import write_impacts  # noqa: PLC0415 - loads the analysis

    write_impacts(folder, description(name, setup), rows, found.impacts)


def _add(
    found: Converted, row: Sequence[str], names: Sequence[str], columns: Sequence[Column]
) -> None:
    values, settings = dict[str, float](), dict[str, float]()
    for text, name, column in zip(row, names, columns, strict=True):
        if column.meaning == NOT_USED or not text.strip():
            continue
        value = _number(text, name) * column.factor
        if column.meaning == SETTING:
            settings[_column_name(name)] = value
        else:
            values[column.meaning] = value
    before, after = _speed(values, BEFORE), _speed(values, AFTER)
    if after > before:
        raise ValueError(f"it parts faster ({after:.3g} m/s) than it met ({before:.3g} m/s)")
    for column in columns:
        if column.meaning.startswith(SIGMA) and values.get(column.meaning, 0.0) <= 0:
            raise ValueError(f"no {MEANINGS[column.meaning].words}")
    sliding = abs(values["v_s"]) if "v_s" in values else math.nan
    impact = ImpactRow(
        len(found.impacts) + 1,
        (-before, sliding, after, values.get("v_s_after", math.nan)),
        tuple(values.get(name) for name in SIGMAS),
    )
    found.impacts.append(impact)
    found.settings.append(settings)


def _speed(values: Mapping[str, float], names: Sequence[str]) -> float:
    speed, height = names
    words = MEANINGS[speed].words
    if speed in values:
        found = abs(values[speed])
    elif height in values and values[height] >= 0:
        words, found = MEANINGS[height].words, math.sqrt(2 * GRAVITY * values[height])
    else:
        raise ValueError(f"no {words}")
    if found == 0 and names == BEFORE:
        raise ValueError(f"the {words} is 0")
    return found


def _number(text: str, name: str) -> float:
    """Return a number; a decimal comma is one where no point stands beside it."""
    plain = text.strip().replace("\u2212", "-")
    if "." not in plain:
        plain = plain.replace(",", ".")
    try:
        value = float(plain)
    except ValueError as error:
        raise ValueError(f"{name}: “{text.strip()[:20]}” is no number") from error
    if not math.isfinite(value):
        raise ValueError(f"{name}: “{text.strip()}” is no finite number")
    return value


def _plain(name: str) -> tuple[str, str]:
    """Return the letters of a column's name, and its unit: in brackets, or its last word."""
    bare, _, unit = name.strip().partition("(")
    if not unit:
        bare, _, unit = name.strip().partition("[")
    unit = unit.strip(" )]")
    for known in (u for kind in UNITS.values() for u in kind if u):
        for written in (f"_{known.replace('/s', '_per_s')}", f" {known}"):
            if not unit and bare.lower().endswith(written):
                bare, unit = bare[: -len(written)].rstrip(" ,;:"), known
    return re.sub(r"[^a-z]", "", bare.lower()), unit


def unit_in(name: str) -> str:
    """Return the unit that stands in a column's name; empty for none."""
    return _plain(name)[1]


def _column_name(name: str) -> str:
    """Return the name of a setting as the list of shots takes it."""
    plain = re.sub(r"\W+", "_", name.strip().lower()).strip("_") or "column"
    return f"{plain}_" if plain in {"shot", "time", "excluded", "note", "tags"} else plain
