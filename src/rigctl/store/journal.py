"""The audit: every transition of the rig, appended and chained by digests."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import Row, Select, select

from rigctl.store.integrity import chain
from rigctl.store.records import JournalEntry
from rigctl.store.sql.database import Database
from rigctl.store.sql.schema import transitions


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
        fields: dict[str, object] = {
            "at": at.isoformat(),
            "before": before,
            "after": after,
            "actor": actor,
            "reason": reason,
            "shot": shot,
        }
        with self._database.writing() as connection:
            return _entry(chain.append(connection, transitions, fields))

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
        with self._database.reading() as connection:
            rows = connection.execute(select(transitions).order_by(transitions.c.number))
            return chain.verify(rows, self._database.name, "transition")


def _latest() -> Select[Any]:
    return select(transitions).order_by(transitions.c.number.desc()).limit(1)


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
