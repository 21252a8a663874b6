"""shots.csv of an imported campaign with what people changed since, and with nothing else."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping

from analysis.exchange.shot_list import EXCLUDED, NOTE, TAGS
from rigctl.store import ShotRecord

_BOM = "\ufeff"


def amended(content: bytes, shots: Mapping[int, ShotRecord]) -> bytes:
    """Return a shot list in which exclusions, notes and tags are those of the catalogue.

    Where they are the same, the same bytes come back; a column is added only where it is needed.
    """
    text = content.decode("utf-8")
    bom = _BOM if text.startswith(_BOM) else ""
    rows = [row for row in csv.reader(io.StringIO(text.removeprefix(_BOM), newline="")) if row]
    names = [name.strip() for name in rows[0]]
    changed = False
    for name in (EXCLUDED, NOTE, TAGS):
        place = names.index(name) if name in names else None
        for row in rows[1:]:
            shot = shots[int(row[names.index("shot")])]
            stated = "" if place is None else row[place]
            if _parsed(name, stated) == _parsed(name, _field(name, shot)):
                continue
            changed = True
            if place is None:
                place = _add_column(names, rows, name)
            row[place] = _field(name, shot)
    if not changed:
        return content
    written = io.StringIO(newline="")
    end = "\r\n" if b"\r\n" in content else "\n"
    csv.writer(written, lineterminator=end).writerows(rows)
    return (bom + written.getvalue()).encode()


def tags_in(field: str) -> tuple[str, ...]:
    """Return the tags that stand in one field."""
    return tuple(filter(None, field.split(";")))


def tags_field(tags: tuple[str, ...]) -> str:
    """Return the field in which tags stand."""
    return ";".join(tags)


def _field(name: str, shot: ShotRecord) -> str:
    fields = {EXCLUDED: shot.excluded, NOTE: shot.note, TAGS: tags_field(shot.tags)}
    return fields[name] or ""


def _parsed(name: str, field: str) -> object:
    return set(tags_in(field)) if name == TAGS else field


def _add_column(names: list[str], rows: list[list[str]], name: str) -> int:
    names.append(name)
    rows[0].append(name)
    for row in rows[1:]:
        row.append("")
    return len(names) - 1
