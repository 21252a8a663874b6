"""Everything that survives, behind one object that one daemon owns."""

from __future__ import annotations

import logging
import os
import shutil
from collections.abc import Callable, Collection, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from rigctl.cameras.frames import FrameSequence
from rigctl.errors import NotFoundError, RigError
from rigctl.listeners import Listeners
from rigctl.store.campaigns import CampaignRecord, Campaigns, Fits
from rigctl.store.catalogue import Catalogue, Change
from rigctl.store.edits import Edits
from rigctl.store.folders import ShotFolders
from rigctl.store.imports import Imports
from rigctl.store.journal import Journal
from rigctl.store.orders import Orders, order_document, outcome_document
from rigctl.store.ownership import own, owned_elsewhere, refused
from rigctl.store.records import NewShot, ShotRecord
from rigctl.store.sql.opened import open_catalogue
from rigctl.store.states import ShotState
from rigctl.store.sweeps import Sweeps

_log = logging.getLogger(__name__)


def _free_bytes(folder: Path) -> int:
    return shutil.disk_usage(folder).free


class Store:
    """Catalogue, audit and shot folders below one folder.

    One process owns it at a time: a second would take the first one's running shots for shots
    left over from a crash. A process that only edits, imports or copies may open it `shared`.

    Parameters
    ----------
    folder
        Created if it is absent.
    database
        URL of a PostgreSQL database for the catalogue; None: a SQLite file in the folder.
    shared
        Own it no longer than opening takes, and not at all where another process does. The rig
        must not be recovered or run on it.
    busy_timeout_s
        Longest wait for another program's lock on the catalogue, s.
    free_bytes
        How the free space of a folder is measured.

    Raises
    ------
    StoreError
        The folder cannot be written, another process owns it, or a later version wrote it.
    """

    def __init__(
        self,
        folder: Path,
        *,
        database: str | None = None,
        shared: bool = False,
        busy_timeout_s: float = 5.0,
        free_bytes: Callable[[Path], int] = _free_bytes,
    ) -> None:
        self.path, self.address = folder.absolute(), database
        self.listeners: Listeners[ShotRecord] = Listeners()
        self.campaign_listeners: Listeners[CampaignRecord] = Listeners()
        self._free_bytes = free_bytes
        self._owned = own(self.path, shared=shared)
        try:
            self._database = open_catalogue(
                self.path, database, busy_timeout_s, migrate=self._owned >= 0
            )
        except BaseException:
            self._disown()
            raise
        if shared:
            self._disown()
        elif not self._database.own():
            self.close()
            raise owned_elsewhere(self._database.name)
        self.catalogue = Catalogue(self._database)
        self.journal = Journal(self._database)
        self.campaigns = Campaigns(self._database)
        self.sweeps = Sweeps(self._database, self.path)
        self.edits = Edits(self._database)
        self.imports = Imports(self._database, self.path)
        self.folders = ShotFolders(self.path)
        self.orders = Orders(self.folders)
        self.fits = Fits(self.path)

    def accept(
        self, key: str, body_hash: str, describe: Callable[[], NewShot]
    ) -> tuple[ShotRecord, bool]:
        """Claim a key and create its shot; as `Catalogue.accept`."""
        record, known = self.catalogue.accept(key, body_hash, describe, self.orders.keep)
        if not known:
            self.listeners.notify(record)
        return record, known

    def move(self, shot: str, to: ShotState, change: Change | None = None) -> ShotRecord:
        """Give a shot its next state, durably; as `Catalogue.move`. Notifies listeners.

        With `stored` the digest of its manifest goes into the catalogue, with a result that of
        its file. A shot that ends without frames gets a manifest with the reason.
        """
        change = change or Change()
        if to is ShotState.STORED:
            change = replace(change, manifest=self.folders.digest(shot))
        if change.results is not None:
            change = replace(change, result=self.folders.result_digest(shot, change.results))
        record = self.catalogue.move(shot, to, change)
        if record.outcome is not None:
            self._settle(record)
        return self._notified(record)

    def keep_frames(
        self, shot: ShotRecord, frames: FrameSequence, manifest: Mapping[str, Any]
    ) -> Path:
        """Write a shot's frames and manifest, with its row of the catalogue.

        Raise as `ShotFolders.write`.
        """
        document = self._stated(replace(shot, outcome=ShotState.STORED))
        return self.folders.write(shot.id, frames, {**document, **manifest})

    def settle(self) -> None:
        """Write down the ends that the disk refused; forget orders that were never acknowledged."""
        for shot in list(self.orders.all()):
            try:
                record = self.catalogue.shot(shot)
            except NotFoundError:
                self.orders.forget(shot)
                continue
            if record.outcome is not None:
                self._settle(record)

    def is_imported(self, campaign: str) -> bool:
        """Say whether a campaign was imported: it takes no shots of this rig."""
        first = self.shots(campaign=campaign, limit=1)
        return bool(first) and first[0].imported_as is not None

    def shot(self, shot: str) -> ShotRecord:
        """Return one shot; raise `NotFoundError` if there is none of that name."""
        return self.catalogue.shot(shot)

    def shots(
        self,
        *,
        campaign: str | None = None,
        state: ShotState | None = None,
        excluded: bool | None = None,
        tag: str | None = None,
        limit: int = 100,
        after: str | None = None,
    ) -> list[ShotRecord]:
        """Return shots, oldest first; as `Catalogue.shots`."""
        return self.catalogue.shots(
            campaign=campaign, state=state, excluded=excluded, tag=tag, limit=limit, after=after
        )

    def exclude(self, shot: str, reason: str, actor: str) -> ShotRecord:
        """Leave a shot out of every fit; as `Edits.exclude`. Notifies listeners."""
        return self._notified(self.edits.exclude(shot, reason, actor))

    def include(self, shot: str, actor: str) -> ShotRecord:
        """Let a shot count again; as `Edits.include`. Notifies listeners."""
        return self._notified(self.edits.include(shot, actor))

    def annotate(self, shot: str, note: str | None, actor: str) -> ShotRecord:
        """Give a shot another note, or none; as `Edits.annotate`. Notifies listeners."""
        return self._notified(self.edits.annotate(shot, note, actor))

    def tag(self, shot: str, tags: Collection[str], actor: str) -> ShotRecord:
        """Give a shot exactly these tags; as `Edits.tag`. Notifies listeners."""
        return self._notified(self.edits.tag(shot, tags, actor))

    def annotate_campaign(self, campaign: str, note: str | None, actor: str) -> CampaignRecord:
        """Give a campaign another note, or none; as `Edits`. Notifies campaign listeners."""
        self.edits.annotate_campaign(campaign, note, actor)
        return self._campaign_notified(campaign)

    def tag_campaign(self, campaign: str, tags: Collection[str], actor: str) -> CampaignRecord:
        """Give a campaign exactly these tags; as `Edits`. Notifies campaign listeners."""
        self.edits.tag_campaign(campaign, tags, actor)
        return self._campaign_notified(campaign)

    def frames(self, shot: str) -> FrameSequence:
        """Return a shot's frames; as `ShotFolders.frames`."""
        return self.folders.frames(shot)

    def result(self, shot: str, number: int | None = None) -> dict[str, Any]:
        """Return a shot's latest result, or the one of that number; as `ShotFolders.result`."""
        return self.folders.result(shot, number)

    def free_mb(self) -> float:
        """Return the free space of the store's file system in 10^6 bytes.

        Raises
        ------
        StoreError
            The folder went away.
        """
        try:
            return self._free_bytes(self.path) / 1e6
        except OSError as error:
            raise refused(self.path, error) from error

    def check(self) -> None:
        """Write to folder and catalogue to prove that both take it; raise `StoreError` if not."""
        probe = self.path / ".probe"
        try:
            with probe.open("wb") as file:
                file.write(bytes(4096))
                file.flush()
                os.fsync(file.fileno())
            probe.unlink()
        except OSError as error:
            raise refused(self.path, error) from error
        self._database.check()

    def close(self) -> None:
        """Close the catalogue and give up the folder. Safe to call twice."""
        self._database.close()
        self._disown()

    def _disown(self) -> None:
        if self._owned >= 0:
            os.close(self._owned)
            self._owned = -1

    def _settle(self, record: ShotRecord) -> None:
        """Put the end of a shot beside the others, in the place of its order.

        What the disk refuses is left to the next start: the row is what counts.
        """
        try:
            if not self.orders.has(record.id):
                return
            if record.manifest is None:
                if self.folders.digest(record.id) is None:
                    if record.outcome is ShotState.STORED:
                        # Its frames have a manifest of their own.
                        return
                    self.folders.write(record.id, None, self._stated(record))
                self.catalogue.stored(record.id, str(self.folders.digest(record.id)))
            self.orders.forget(record.id)
        except (RigError, OSError) as error:
            _log.warning("shot %s: its end is not beside the shots: %s", record.id, error)

    def _stated(self, record: ShotRecord) -> dict[str, Any]:
        head = self._database.head()
        return {
            **order_document(record, self.catalogue.request(record)),
            "fired_at": None if record.fired_at is None else record.fired_at.isoformat(),
            "outcome": outcome_document(record),
            "audit": None if head is None else asdict(head),
        }

    def _notified(self, record: ShotRecord) -> ShotRecord:
        self.listeners.notify(record)
        return record

    def _campaign_notified(self, campaign: str) -> CampaignRecord:
        record = self.campaigns.one(campaign)
        self.campaign_listeners.notify(record)
        return record
