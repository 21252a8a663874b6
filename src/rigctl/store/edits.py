"""What people change afterwards: exclusions, notes, tags; each change with its line of audit."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, Row, delete, insert, select, update

from rigctl.errors import SettingsError
from rigctl.plain_text import require_plain
from rigctl.store.campaign_remarks import (
    Remarks,
    remarks_of,
    require_campaign,
    set_note,
    set_tags,
)
from rigctl.store.integrity import chain
from rigctl.store.integrity.ledger import note, note_removed
from rigctl.store.records import Edit, ShotRecord
from rigctl.store.shot_rows import one
from rigctl.store.sql.database import Database
from rigctl.store.sql.schema import edits, shot_tags, shots

COMMISSIONING = "commissioning"
"""The act of an entry that says what was seen of a real rig before it may fire."""


def utc_now() -> datetime:
    """Return the time, UTC."""
    return datetime.now(UTC)


@dataclass(frozen=True, slots=True)
class _Change:
    """The columns of an entry, in the order of the table, that are not given by its place."""

    actor: str
    act: str
    subject: str
    before: str | None
    after: str | None


class Edits:
    """Changes to what is known of shots and campaigns. Any thread may call any of the methods.

    A change and its audit are on disk together or not at all, and no shot is ever deleted. What
    changes nothing is not written down.

    Parameters
    ----------
    now
        The clock, UTC.
    """

    def __init__(self, database: Database, now: Callable[[], datetime] = utc_now) -> None:
        self._database, self._now = database, now

    def exclude(self, shot: str, reason: str, actor: str) -> ShotRecord:
        """Leave a shot out of every fit, for a reason; one that is left out gets another reason.

        Raises
        ------
        NotFoundError
            There is no such shot.
        SettingsError
            No reason is given.
        StoreError
            It is not on disk.
        """
        if not reason.strip():
            raise SettingsError(
                "is empty", part="reason", todo="say why the shot does not count", shot=shot
            )
        with self._database.writing() as connection:
            before = one(connection, shot).excluded
            self._set(connection, shot, excluded=reason)
            self._note(connection, _Change(actor, "excluded", shot, before, reason))
            return one(connection, shot)

    def include(self, shot: str, actor: str) -> ShotRecord:
        """Let a shot count again; raise as `exclude`."""
        with self._database.writing() as connection:
            before = one(connection, shot).excluded
            self._set(connection, shot, excluded=None)
            self._note(connection, _Change(actor, "included", shot, before, None))
            return one(connection, shot)

    def annotate(self, shot: str, note: str | None, actor: str) -> ShotRecord:
        """Put a note in the place of a shot's note, or take it away; raise as `exclude`."""
        with self._database.writing() as connection:
            before = one(connection, shot).note
            self._set(connection, shot, note=note)
            self._note(connection, _Change(actor, "noted", shot, before, note))
            return one(connection, shot)

    def tag(self, shot: str, tags: Collection[str], actor: str) -> ShotRecord:
        """Give a shot exactly these tags; raise as `exclude`."""
        with self._database.writing() as connection:
            present = one(connection, shot)
            mine = shot_tags.c.shot == present.number
            note_removed(connection, shot_tags, connection.execute(select(shot_tags).where(mine)))
            connection.execute(delete(shot_tags).where(mine))
            new = sorted(set(tags))
            if new:
                rows = [{"shot": present.number, "tag": tag} for tag in new]
                connection.execute(insert(shot_tags), rows)
                note(connection, shot_tags, mine)
            self._note(connection, _tagged(actor, "tagged", shot, (present.tags, new)))
            return one(connection, shot)

    def annotate_campaign(self, campaign: str, note: str | None, actor: str) -> None:
        """Put a note in the place of a campaign's note, or take it away.

        Raises
        ------
        NotFoundError
            There is no such campaign.
        StoreError
            It is not on disk.
        """
        with self._database.writing() as connection:
            require_campaign(connection, campaign)
            before = remarks_of(connection, campaign).get(campaign, Remarks()).note
            set_note(connection, campaign, note)
            self._note(connection, _Change(actor, "campaign noted", campaign, before, note))

    def tag_campaign(self, campaign: str, tags: Collection[str], actor: str) -> None:
        """Give a campaign exactly these tags; raise as `annotate_campaign`."""
        with self._database.writing() as connection:
            require_campaign(connection, campaign)
            before = remarks_of(connection, campaign).get(campaign, Remarks()).tags
            set_tags(connection, campaign, tags)
            both = (before, sorted(set(tags)))
            self._note(connection, _tagged(actor, "campaign tagged", campaign, both))

    def wrong_keys(self, address: str, how_many: str) -> None:
        """Write down that many wrong keys came from an address; raise `StoreError`."""
        with self._database.writing() as connection:
            self._note(connection, _Change(address, "wrong keys", address, None, how_many))

    def key_changed(self, actor: str, act: str, name: str, after: str) -> None:
        """Write down that a named key was added or revoked; raise `StoreError`."""
        with self._database.writing() as connection:
            self._note(connection, _Change(actor, act, name, None, after))

    def tape_erased(self, actor: str, recorder: str, sessions: str) -> None:
        """Write down that somebody had a tape erased, and what was on it; raise `StoreError`."""
        with self._database.writing() as connection:
            self._note(connection, _Change(actor, "tape erased", recorder, sessions, "empty"))

    def commissioning(self, actor: str, about: str, text: str) -> None:
        """Write down what was seen of a step of the commissioning; raise `StoreError`."""
        with self._database.writing() as connection:
            self._note(connection, _Change(actor, COMMISSIONING, about, None, text))

    def commissionings(self) -> list[Edit]:
        """Return all that was written down of the commissioning, oldest first."""
        query = select(edits).where(edits.c.act == COMMISSIONING).order_by(edits.c.number)
        with self._database.reading() as connection:
            return [_edit(row) for row in connection.execute(query)]

    def entries(self, *, after: int = 0, limit: int = 100) -> list[Edit]:
        """Return up to `limit` changes with numbers above `after`, oldest first."""
        query = select(edits).where(edits.c.number > after).order_by(edits.c.number).limit(limit)
        with self._database.reading() as connection:
            return [_edit(row) for row in connection.execute(query)]

    def verify(self) -> int:
        """Recompute the chain and return the number of changes.

        Raises
        ------
        StoreError
            An entry does not fit the one before it; the error names its number.
        """
        with self._database.reading() as connection:
            rows = connection.execute(select(edits).order_by(edits.c.number))
            return chain.verify(rows, self._database.name, "edit")

    def _set(self, connection: Connection, shot: str, **values: str | None) -> None:
        connection.execute(update(shots).where(shots.c.id == shot).values(values))
        note(connection, shots, shots.c.id == shot)

    def _note(self, connection: Connection, change: _Change) -> None:
        if change.before == change.after:
            return
        require_plain(change.after, change.act, change.subject)
        require_plain(change.actor, "actor")
        fields: dict[str, object] = {"at": self._now().isoformat(), **asdict(change)}
        chain.append(connection, edits, fields)


def _tagged(
    actor: str, act: str, subject: str, tags: tuple[Sequence[str], Sequence[str]]
) -> _Change:
    """Return the change from the first tags to the second."""
    before, after = (",".join(words) or None for words in tags)
    return _Change(actor, act, subject, before, after)


def _edit(row: Row[Any]) -> Edit:
    return Edit(
        row.number,
        datetime.fromisoformat(row.at),
        row.actor,
        row.act,
        row.subject,
        row.before,
        row.after,
        row.digest,
    )
