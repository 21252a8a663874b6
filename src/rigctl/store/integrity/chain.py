"""Digests that chain the entries of an audit: a changed, removed or inserted one breaks them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from typing import Any

from sqlalchemy import Connection, Row, Table, insert, select

from rigctl.errors import StoreError
from rigctl.store.integrity.ledger import START, note


def append(connection: Connection, table: Table, fields: dict[str, object]) -> Row[Any]:
    """Append an entry to a chained table, inside the caller's transaction, and return its row.

    `fields` are the columns between `number` and `digest`, in the order of the table.
    """
    query = select(table.c.number, table.c.digest).order_by(table.c.number.desc()).limit(1)
    last = connection.execute(query).one_or_none()
    number, previous = (last.number + 1, last.digest) if last else (1, START)
    digest = _digest(previous, (number, *fields.values()))
    connection.execute(insert(table).values(number=number, **fields, digest=digest))
    note(connection, table, table.c.number == number)
    return connection.execute(select(table).where(table.c.number == number)).one()


def verify(rows: Iterable[Row[Any]], part: str, entry: str) -> int:
    """Recompute a chain and return the number of its entries.

    Parameters
    ----------
    rows
        All of the table, by number.
    part, entry
        What the error names: the catalogue, and what one entry is called.

    Raises
    ------
    StoreError
        An entry does not fit the one before it; the error names its number.
    """
    previous, count = START, 0
    for row in rows:
        count += 1
        if row.number != count or row.digest != _digest(previous, tuple(row)[:-1]):
            raise StoreError(
                "the audit was altered",
                part=part,
                value=f"{entry} {row.number}",
                limit="the digest that was written with it",
                todo="compare with a backup before trusting later entries",
            )
        previous = row.digest
    return count


def _digest(previous: str, fields: tuple[object, ...]) -> str:
    text = json.dumps([previous, *fields], separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
