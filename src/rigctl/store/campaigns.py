"""Campaigns: the shots that were fired under one name, and the fits that were saved of them.

Every version of a fit stays, none takes the place of another::

    campaigns/nylon-2/fits/base-0001.json      the first fit that was saved as `base`
                           base-0002.json      the second
"""

from __future__ import annotations

import json
import os
import re
import uuid
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from sqlalchemy import func, select

from rigctl.documents import Json
from rigctl.errors import NotFoundError, StoreError
from rigctl.store.campaign_remarks import Remarks, no_such_campaign, remarks_of
from rigctl.store.durable import make_folders, sync_folder, write_synced
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
            with self._database.reading() as connection:
                raise no_such_campaign(connection, name)
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


_FILE = re.compile(r"(?P<name>.+)-(?P<version>\d{4,})\.json")


class Fits:
    """The fits below `root`/campaigns. Any thread may call any of the methods."""

    def __init__(self, root: Path) -> None:
        self._campaigns = root / "campaigns"

    def add(self, campaign: str, name: str, document: Mapping[str, Any]) -> int:
        """Save a fit as the next version of its name; return the version, counted from 1.

        Raises
        ------
        StoreError
            The disk refused, or the document holds a number that is not finite.
        """
        folder = self._folder(campaign)
        partial = folder / f".{uuid.uuid4().hex}.partial"
        with _store_errors(folder):
            text = json.dumps(document, allow_nan=False, indent=1).encode()
            make_folders(folder)
            try:
                write_synced(partial, lambda file: file.write(text))
                version = self._link(partial, campaign, name)
            finally:
                partial.unlink(missing_ok=True)
            sync_folder(folder)
        return version

    def versions(self, campaign: str) -> list[tuple[str, int]]:
        """Return name and version of every saved fit of a campaign, in order."""
        found = [_FILE.fullmatch(path.name) for path in self._folder(campaign).glob("*.json")]
        return sorted((match["name"], int(match["version"])) for match in found if match)

    def fit(self, campaign: str, name: str, version: int | None = None) -> tuple[int, Json]:
        """Return one version of a fit, the latest by default, with its number.

        Raises
        ------
        NotFoundError
            No fit was saved under this name, or not in this version.
        StoreError
            The file cannot be read.
        """
        known = [number for own, number in self.versions(campaign) if own == name]
        if not known or (version is not None and version not in known):
            raise NotFoundError(
                "no such fit",
                part=f"campaign {campaign}",
                value=repr(name) if version is None else f"{name!r}, version {version}",
                todo="list the campaign's fits",
            )
        chosen = max(known) if version is None else version
        path = self._path(campaign, name, chosen)
        with _store_errors(path):
            document: Json = json.loads(path.read_bytes())
        return chosen, document

    def _link(self, partial: Path, campaign: str, name: str) -> int:
        """Give a whole file the next free version."""
        while True:
            known = [number for own, number in self.versions(campaign) if own == name]
            version = max(known, default=0) + 1
            try:
                # A link, unlike a rename, refuses to take the place of a file that is there.
                os.link(partial, self._path(campaign, name, version))
            except FileExistsError:
                continue
            return version

    def _folder(self, campaign: str) -> Path:
        return self._campaigns / campaign / "fits"

    def _path(self, campaign: str, name: str, version: int) -> Path:
        return self._folder(campaign) / f"{name}-{version:04d}.json"


@contextmanager
def _store_errors(path: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, ValueError) as error:
        what = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise StoreError(what, part=str(path), todo="free or repair the disk") from error
