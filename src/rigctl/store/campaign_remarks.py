"""Remarks on campaigns: one note and some tags each, read and changed in one transaction."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from sqlalchemy import ColumnElement, Connection, Table, delete, func, insert, select

from rigctl.errors import NotFoundError
from rigctl.store.integrity import ledger
from rigctl.store.sql.schema import campaign_notes, campaign_tags, shots

MOST_NAMED = 12
"""Campaigns that the error of a name that is none lists."""


@dataclass(frozen=True, slots=True)
class Remarks:
    """A campaign's note, None without any, and its tags in alphabetical order."""

    note: str | None = None
    tags: tuple[str, ...] = ()


def remarks_of(connection: Connection, campaign: str | None = None) -> Mapping[str, Remarks]:
    """Return the remarks on one campaign, or on all; campaigns without remarks are left out."""
    noted, tagged = select(campaign_notes), select(campaign_tags).order_by(campaign_tags.c.tag)
    if campaign is not None:
        noted = noted.where(campaign_notes.c.campaign == campaign)
        tagged = tagged.where(campaign_tags.c.campaign == campaign)
    notes = {row.campaign: row.note for row in connection.execute(noted)}
    tags: dict[str, list[str]] = {}
    for row in connection.execute(tagged):
        tags.setdefault(row.campaign, []).append(row.tag)
    return {
        name: Remarks(notes.get(name), tuple(tags.get(name, ()))) for name in notes.keys() | tags
    }


def set_note(connection: Connection, campaign: str, note: str | None) -> None:
    """Put a note in the place of a campaign's note, or take it away."""
    mine = _cleared(connection, campaign_notes, campaign)
    if note is not None:
        connection.execute(insert(campaign_notes).values(campaign=campaign, note=note))
        ledger.note(connection, campaign_notes, mine)


def set_tags(connection: Connection, campaign: str, tags: Collection[str]) -> None:
    """Give a campaign exactly these tags."""
    mine = _cleared(connection, campaign_tags, campaign)
    if tags:
        rows = [{"campaign": campaign, "tag": tag} for tag in sorted(set(tags))]
        connection.execute(insert(campaign_tags), rows)
        ledger.note(connection, campaign_tags, mine)


def _cleared(connection: Connection, table: Table, campaign: str) -> ColumnElement[bool]:
    """Remove the rows of a campaign from a table; return the condition that selects them."""
    mine: ColumnElement[bool] = table.c.campaign == campaign
    ledger.note_removed(connection, table, connection.execute(select(table).where(mine)))
    connection.execute(delete(table).where(mine))
    return mine


def require_campaign(connection: Connection, campaign: str) -> None:
    """Raise `NotFoundError` if no shot was fired or imported under this name."""
    query = select(shots.c.number).where(shots.c.campaign == campaign).limit(1)
    if connection.execute(query).one_or_none() is None:
        raise no_such_campaign(connection, campaign)


def no_such_campaign(connection: Connection, name: str) -> NotFoundError:
    """Return the error of a name that is no campaign's; it says which there are, the latest."""
    query = (
        select(shots.c.campaign)
        .where(shots.c.campaign.is_not(None))
        .group_by(shots.c.campaign)
        .order_by(func.max(shots.c.number).desc())
        .limit(MOST_NAMED + 1)
    )
    known = list(connection.execute(query).scalars())
    listed = ", ".join(known[:MOST_NAMED]) + (", ..." if len(known) > MOST_NAMED else "")
    there = f"there are {listed}" if known else "there is none in this store yet"
    return NotFoundError("no such campaign", value=repr(name), todo=there)
