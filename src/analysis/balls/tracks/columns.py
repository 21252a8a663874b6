"""Which column of a table is what, by the names and units that programs write."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

TIMES = ("t", "time", "times", "positiont", "seconds", "timestamp")
FRAMES = (
    *("frame", "frames", "framenumber", "frameno", "frameidx", "frameindex", "frameid"),
    *("slice", "slicen", "image", "step"),
)
THINGS = ("particle", "particleid", "trackid", "trackn", "track", "trajectory", "trajid")
"""Names of columns, those that a program writes beside another last."""
PLACE = re.compile(
    r"(pt\d+(?:cam\d+)?|position|pos|centroid|cent(?:er|re)|ball|c|)([xyz])\d*"
    r"(m|pos|position|cent(?:er|re)|coord|coordinate|)"
)
"""Names of places without units and punctuation: x, POSITION_X, X1, pt1_cam1_X, XM, cx."""
PREFIX = re.compile(r".*:")
"""Logger Pro's and Capstone's name of a run before that of a column."""
RUN = re.compile(r",?\s*run ?#?\d+$", re.IGNORECASE)
NAMED = "px|pixels?|mm|cm|m|ft|in|inch|ms|us|µs|s|min"
UNIT = re.compile(rf"[\[(]\s*([a-zµμ/\"']*)\s*[\])]|[_ /]({NAMED})$", re.IGNORECASE)
PIXELS = {"", "px", "pix", "pixel", "pixels"}
METRES = {
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1.0),
    **{"dm": 0.1, "cm": 1e-2, "mm": 1e-3, "nm": 1e-9},
    **dict.fromkeys(("um", "µm", "μm", "micron", "microns"), 1e-6),
    **dict.fromkeys(("in", "inch", "inches", '"'), 0.0254),
    **dict.fromkeys(("ft", "foot", "feet", "'"), 0.3048),
}
SECONDS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec", "millisecond", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "µs", "μs", "microseconds"), 1e-6),
    **dict.fromkeys(("min", "minute", "minutes"), 60.0),
}
COUNTED = {"", "frame", "frames"}
"""Units of times that are numbers of frames, or state none."""
BOUNCE = re.compile(r"bounce ?(\d+)(?: ?[(\[]([a-zµμ]*)[\])])?", re.IGNORECASE)
"""Names of times at which a ball was heard, as phyphox writes them."""


@dataclass(frozen=True, slots=True)
class Columns:
    """Which column is what; `tracks` are those of the places of each thing in a row."""

    time: int | None
    frame: int | None
    thing: int | None
    tracks: tuple[tuple[int, ...], ...]


def columns_of(row: Sequence[str]) -> Columns | None:
    """Return what a row of names says; None: it names no places."""
    names = [_plain(cell) for cell in row]
    found = {k: place for k, name in enumerate(names) if (place := PLACE.fullmatch(name))}
    kinds = [_kind(place) for place in found.values()]
    # Programs write the middle of a shape in several ways beside one another.
    kind = ("", "") if ("", "") in kinds else kinds[0] if kinds else None
    tracks: list[list[int]] = []
    axes = ""
    for index, place in found.items():
        if _kind(place) != kind:
            continue
        if not tracks or place[2] in axes:
            tracks, axes = [*tracks, []], ""
        tracks[-1].append(index)
        axes += place[2]
        tracks[-1].sort(key=lambda own: found[own][2])
    kept = [track for track in tracks if len(track) == max(map(len, tracks))]
    if "shot" in names or not kept or len(kept[0]) < 2:
        return None
    time, frame, thing = (
        next((names.index(name) for name in known if name in names), None)
        for known in (TIMES, FRAMES, THINGS)
    )
    return Columns(time, frame, thing, tuple(map(tuple, kept)))


def _kind(place: re.Match[str]) -> tuple[str, str]:
    """Return how a program names places, whatever their number."""
    return re.sub(r"\d", "", place[1]), place[3]


def _plain(cell: str) -> str:
    """Return a column's name in lower case, without its unit and what is no letter or digit."""
    name = RUN.sub("", PREFIX.sub("", cell.strip()))
    return re.sub(r"[^a-z0-9]", "", UNIT.sub("", name).lower())


def unit_of(row: Sequence[str], index: int | None) -> str:
    """Return the unit in a cell, in lower case; empty where there is none."""
    if index is None or index >= len(row):
        return ""
    found = UNIT.search(RUN.sub("", row[index].strip()))
    return "" if found is None else (found[1] or found[2] or "").lower()
