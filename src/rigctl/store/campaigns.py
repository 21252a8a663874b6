"""Campaigns: the shots that were fired under one name."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import func, select

from rigctl.errors import NotFoundError
from rigctl.store.campaign_remarks import Remarks, no_such_campaign, remarks_of
from rigctl.store.sql.database import Database
from rigctl.store.sql.schema import shots
from rigctl.store.states import ShotState


@dataclass(frozen=True, slots=True)
class CampaignRecord:
    """One campaign as the catalogue has it.

    Attributes
    ----------
    states
        How many of its shots stand in each state; states without a shot are left out.
    excluded
        How many of them a person left out of every fit.
    first_at, last_at
        When its first and its last shot were accepted, UTC.
    note, tags
        Remarks of people; tags in alphabetical order.
    """

    name: str
    states: dict[ShotState, int]
    first_at: datetime
    last_at: datetime
    excluded: int = 0
    note: str | None = None
    tags: tuple[str, ...] = ()

    @property
    def shots(self) -> int:
        """How many shots it has, whatever became of them."""
        return sum(self.states.values())


class Campaigns:
    """Campaigns in the catalogue; any thread may call any of the methods."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def all(self, tag: str | None = None) -> list[CampaignRecord]:
        """Return every campaign, or those with a tag, the one with the latest shot first."""
        found = [one for one in self._records(None) if tag is None or tag in one.tags]
        return sorted(found, key=lambda campaign: campaign.last_at, reverse=True)

    def one(self, name: str) -> CampaignRecord:
        """Return one campaign; raise `NotFoundError` if no shot was fired under this name."""
        found = self._records(name)
        if not found:
            raise no_such_campaign(name)
        return found[0]

    def measured(self, name: str) -> list[tuple[str, int]]:
        """Return the shots of a campaign that are measured, each with the number of its result.

        In the order of firing, without those that a person left out.

        Raises
        ------
        NotFoundError
            No shot was fired under this name, or none of them has been measured.
        """
        campaign = self.one(name)
        found = self._measured(name, excluded=False)
        if not found:
            raise NotFoundError(
                "no shot of this campaign has been measured",
                part=f"campaign {name}",
                value=f"{campaign.shots} shots",
                todo="await their analysis, or look at why they were refused",
            )
        return found

    def left_out(self, name: str) -> list[tuple[str, int]]:
        """Return the shots that `measured` would have as well, had a person not left them out."""
        return self._measured(name, excluded=True)

    def _measured(self, name: str, *, excluded: bool) -> list[tuple[str, int]]:
        query = (
            select(shots.c.id, shots.c.results)
            .where(shots.c.campaign == name, shots.c.state == ShotState.ANALYSED)
            .where(shots.c.excluded.is_not(None) == excluded)
            .order_by(shots.c.number)
        )
        with self._database.reading() as connection:
            return [(row.id, row.results) for row in connection.execute(query)]

    def _records(self, name: str | None) -> list[CampaignRecord]:
        query = (
            select(
                shots.c.campaign,
                shots.c.state,
                func.count().label("number"),
                func.min(shots.c.accepted_at).label("first_at"),
                func.max(shots.c.accepted_at).label("last_at"),
                func.count(shots.c.excluded).label("excluded"),
            )
            .where(shots.c.campaign.is_not(None) if name is None else shots.c.campaign == name)
            .group_by(shots.c.campaign, shots.c.state)
            .order_by(shots.c.campaign, shots.c.state)
        )
        states: dict[str, dict[ShotState, int]] = {}
        times: dict[str, list[datetime]] = {}
        excluded = Counter[str]()
        with self._database.reading() as connection:
            for row in connection.execute(query):
                states.setdefault(row.campaign, {})[ShotState(row.state)] = row.number
                both = map(datetime.fromisoformat, (row.first_at, row.last_at))
                times.setdefault(row.campaign, []).extend(both)
                excluded[row.campaign] += row.excluded
            words = remarks_of(connection, name)
        return [
            CampaignRecord(
                campaign,
                found,
                min(times[campaign]),
                max(times[campaign]),
                excluded[campaign],
                own.note,
                own.tags,
            )
            for campaign, found in states.items()
            for own in (words.get(campaign, Remarks()),)
        ]
