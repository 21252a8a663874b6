"""The audit: every transition of the rig, appended and chained by digests."""

from __future__ import annotations

import hashlib
import json
from datetime import datetime
from typing import Any

from sqlalchemy import Row, Select, insert, select

from rigctl.errors import StoreError
from rigctl.store.database import Database
from rigctl.store.records import JournalEntry
from rigctl.store.schema import transitions

_START = "0" * 64


class Journal:
    """Append-only list of transitions; a changed, removed or inserted entry breaks the chain."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def append(
        self,
        *,
        at: datetime,
        before: str,
        after: str,
        actor: str,
        reason: str,
        shot: str | None = None,
    ) -> JournalEntry:
        """Append one transition and return it once it is on disk.

        Raises
        ------
        StoreError
            The entry could not be written.
        """
        with self._database.writing() as connection:
            last = connection.execute(_latest()).one_or_none()
            number, previous = (last.number + 1, last.digest) if last else (1, _START)
            fields = (number, at.isoformat(), before, after, actor, reason, shot)
            digest = _digest(previous, fields)
            names = ("number", "at", "before", "after", "actor", "reason", "shot")
            row = dict(zip(names, fields, strict=True))
            connection.execute(insert(transitions).values(**row, digest=digest))
        return JournalEntry(number, at, before, after, actor, reason, shot, digest)

    def last(self) -> JournalEntry | None:
        """Return the latest entry, or None when the rig has never moved."""
        with self._database.reading() as connection:
            row = connection.execute(_latest()).one_or_none()
        return _entry(row) if row else None

    def entries(self, *, after: int = 0, limit: int = 100) -> list[JournalEntry]:
        """Return up to `limit` entries with numbers above `after`, oldest first."""
        query = select(transitions).where(transitions.c.number > after)
        with self._database.reading() as connection:
            rows = connection.execute(query.order_by(transitions.c.number).limit(limit)).all()
        return [_entry(row) for row in rows]

    def verify(self) -> int:
        """Recompute the chain and return the number of entries.

        Raises
        ------
        StoreError
            An entry does not fit the one before it; the error names its number.
        """
        previous, count = _START, 0
        with self._database.reading() as connection:
            for row in connection.execute(select(transitions).order_by(transitions.c.number)):
                count += 1
                if row.number != count or row.digest != _digest(previous, tuple(row)[:-1]):
                    raise StoreError(
                        "the audit was altered",
                        part=str(self._database.path),
                        value=f"transition {row.number}",
                        limit="the digest that was written with it",
                        todo="compare with a backup before trusting later entries",
                    )
                previous = row.digest
        return count


def _latest() -> Select[Any]:
    return select(transitions).order_by(transitions.c.number.desc()).limit(1)


def _digest(previous: str, fields: tuple[object, ...]) -> str:
    text = json.dumps([previous, *fields], separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _entry(row: Row[Any]) -> JournalEntry:
    return JournalEntry(
        row.number,
        datetime.fromisoformat(row.at),
        row.before,
        row.after,
        row.actor,
        row.reason,
        row.shot,
        row.digest,
    )
