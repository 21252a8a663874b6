"""The ledger: one entry for every change of a row, each closed over the one before it.

An entry names table and row and holds the SHA-256 of the row's content, none where the row is
gone. The chain is keyed (`Seal`), so that a changed, added or removed row of any table of `GUARDED`
disagrees with it. Its head is written elsewhere too: into each shot's manifest, and on request
into a file. A cut tail is found by that.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, Connection, Row, Table, insert, select

from rigctl.errors import CatalogueLostError, StoreError
from rigctl.store.integrity.seal import Seal
from rigctl.store.sql.schema import ledger, metadata

START = "0" * 64
"""In the place of a digest before the first entry."""

BEGUN, RECOVERED = "begun", "recovered"
"""What the first entry is about; a recovered ledger goes on after the last head that is known."""

_OWN = frozenset({"ledger", "probe"})
GUARDED: dict[str, Table] = {t.name: t for t in metadata.sorted_tables if t.name not in _OWN}
"""Tables whose rows have entries in the ledger."""

_CHUNK = 1000

_Entry = tuple[str, str, str | None]
"""Table, row, and content of the row."""


@dataclass(frozen=True, slots=True)
class Anchor:
    """The head of the ledger at one moment: number and digest of its last entry."""

    entry: int
    digest: str


def begin(connection: Connection, seal: Seal, after: Anchor | None = None) -> None:
    """Write the first entry, and one for each row that is there.

    Parameters
    ----------
    after
        The last head that is known of a ledger that was lost; None: there was none.
    """
    last = after or Anchor(0, START)
    about = BEGUN if after is None else RECOVERED
    first: _Entry = (about, json.dumps([last.entry, last.digest]), None)
    _append(connection, seal, last, [first])
    for table in GUARDED.values():
        if found := connection.execute(select(table)).all():
            _append(connection, seal, _head(connection), [_entry(table, row) for row in found])


def note(connection: Connection, table: Table, *where: ColumnElement[bool]) -> None:
    """Write down how these rows stand now; part of every transaction that adds or changes them."""
    found = connection.execute(select(table).where(*where)).all()
    _append(connection, _seal(connection), _head(connection), [_entry(table, row) for row in found])


def note_removed(connection: Connection, table: Table, rows: Iterable[Row[Any]]) -> None:
    """Write down that these rows are gone; part of every transaction that removes them."""
    gone: list[_Entry] = [(table.name, key_of(table, row), None) for row in rows]
    _append(connection, _seal(connection), _head(connection), gone)


def head(connection: Connection) -> Anchor | None:
    """Return the head of the ledger; None where it has no entry."""
    query = select(ledger.c.number, ledger.c.digest).order_by(ledger.c.number.desc()).limit(1)
    row = connection.execute(query).one_or_none()
    return None if row is None else Anchor(row.number, row.digest)


def require_own(connection: Connection, seal: Seal) -> None:
    """Refuse a ledger whose last entry another key has closed.

    Raises
    ------
    CatalogueLostError
        It has, or there is no entry.
    """
    query = select(ledger).order_by(ledger.c.number.desc()).limit(2)
    _head(connection)
    last, *earlier = connection.execute(query).all()
    previous = earlier[0].digest if earlier else before(last).digest
    if last.digest != seal.digest(previous, tuple(last)[:-1]):
        raise CatalogueLostError(
            "the last entry of the audit was not closed by the key of this store",
            part="ledger",
            value=f"entry {last.number}",
            todo="restore the file audit.key from a backup, or look with `rigctl verify`",
        )


def before(first: Row[Any]) -> Anchor:
    """Return the head that the first entry of a ledger goes on from."""
    if first.about not in {BEGUN, RECOVERED}:
        return Anchor(0, START)
    entry, digest = json.loads(first.row)
    return Anchor(entry, digest)


def key_of(table: Table, row: Row[Any]) -> str:
    """Return what names a row within its table."""
    return json.dumps([row._mapping[column] for column in table.primary_key.columns])


def content_of(row: Row[Any]) -> str:
    """Return the SHA-256 of a row's content; empty columns do not count."""
    content = {name: value for name, value in row._mapping.items() if value is not None}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _entry(table: Table, row: Row[Any]) -> _Entry:
    return table.name, key_of(table, row), content_of(row)


def _head(connection: Connection) -> Anchor:
    found = head(connection)
    if found is None:
        raise CatalogueLostError(
            "the audit has lost its entries",
            part="ledger",
            todo="restore the catalogue from a backup, or rebuild it with `rigctl recover`",
        )
    return found


def _seal(connection: Connection) -> Seal:
    seal: Seal | None = connection.get_execution_options().get("seal")
    if seal is None:
        raise StoreError("the audit cannot be continued without its key", part="ledger")
    return seal


def _append(connection: Connection, seal: Seal, last: Anchor, entries: list[_Entry]) -> None:
    number, previous = last.entry, last.digest
    rows: list[dict[str, object]] = []
    for about, row, content in entries:
        number += 1
        previous = seal.digest(previous, (number, about, row, content))
        fields = {"number": number, "about": about, "row": row, "content": content}
        rows.append({**fields, "digest": previous})
    for first in range(0, len(rows), _CHUNK):
        connection.execute(insert(ledger), rows[first : first + _CHUNK])
