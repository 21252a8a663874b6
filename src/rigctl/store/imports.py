"""Imported campaigns: whole in the catalogue, or not there at all.

Everything is written under another name first. One rename and one transaction then make it seen.
What a program leaves that dies between the two belongs to no campaign, and its number is not used
again.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from sqlalchemy import Connection, func, insert, select

from rigctl.errors import NotFoundError, RefusedError, StoreError
from rigctl.settings import ShotSettings
from rigctl.store.campaign_remarks import Remarks, set_note, set_tags
from rigctl.store.durable import FOLDER_MODE, make_folders, sync_folder
from rigctl.store.edits import utc_now
from rigctl.store.folders import sha256
from rigctl.store.integrity import chain
from rigctl.store.integrity.ledger import note
from rigctl.store.sql.database import Database
from rigctl.store.sql.schema import edits, imports, results, shot_tags, shots
from rigctl.store.states import Fired, ShotState

LISTING = "import.json"
_FOLDER = re.compile(r"\.?i(\d{4,})(\.partial)?")


@dataclass(frozen=True, slots=True)
class ImportedShot:
    """A shot of an exchange folder as its row in the catalogue begins.

    Attributes
    ----------
    number
        In the exchange folder.
    settings
        None: pressures and offset are not all stated, or beyond any rig.
    fired_at
        UTC; None: not noted.
    state, failure
        `analysed` with a first result, `stored` with frames alone, or `refused` with the reason.
    frames
        How many; None without any.
    """

    number: int
    settings: ShotSettings | None
    fired_at: datetime | None
    state: ShotState
    frames: int | None
    failure: str | None = None
    note: str | None = None
    tags: tuple[str, ...] = ()
    excluded: str | None = None
    simulated: bool = False
    configuration: str = ""


@dataclass(frozen=True, slots=True)
class Stage:
    """Where the files of an import are written: folder `path`, and the number of the import."""

    number: int
    path: Path

    def shot(self, number: int) -> str:
        """Return the name of the shot that had this number in the exchange folder."""
        return f"i{self.number:04d}-{number:06d}"


class Imports:
    """Table of imports. Each method is all or nothing; any thread may call any of them."""

    def __init__(
        self, database: Database, root: Path, now: Callable[[], datetime] = utc_now
    ) -> None:
        self._database, self._shots, self._now = database, root / "shots", now

    @contextmanager
    def staged(self, campaign: str) -> Iterator[Stage]:
        """Give a fresh folder for the files of an import; what is not published is removed.

        Raises
        ------
        RefusedError
            There is a campaign of this name.
        StoreError
            The disk refused; nothing is left behind.
        """
        with self._database.reading() as connection:
            _require_free(connection, campaign)
            last = connection.execute(select(func.max(imports.c.number))).scalar_one() or 0
        stage: Stage | None = None
        try:
            make_folders(self._shots)
            stage = self._claimed(last)
            yield stage
        except OSError as error:
            raise StoreError(
                f"nothing was imported: {error.strerror or error}",
                part=str(error.filename or self._shots),
                todo="free or repair the disk, then import it again",
            ) from error
        finally:
            if stage is not None:
                shutil.rmtree(stage.path, ignore_errors=True)

    def publish(
        self,
        stage: Stage,
        campaign: str,
        found: Sequence[ImportedShot],
        actor: str,
        words: Remarks,
    ) -> None:
        """Make a campaign of what was staged, with its note and tags, all of it or nothing.

        Raises
        ------
        RefusedError
            Somebody made a campaign of this name meanwhile.
        StoreError
            It is not on disk.
        """
        digest, target = sha256(stage.path / LISTING), self.folder(stage.number)
        with self._database.writing() as connection:
            _require_free(connection, campaign)
            at = self._now().isoformat()
            common = {"campaign": campaign, "actor": actor, "accepted_at": at}
            last = connection.execute(select(func.max(shots.c.number))).scalar_one() or 0
            add_rows(connection, stage, common, found, last + 1)
            row = {"number": stage.number, "campaign": campaign, "digest": digest}
            connection.execute(insert(imports).values(row))
            note(connection, imports, imports.c.number == stage.number)
            set_note(connection, campaign, words.note)
            set_tags(connection, campaign, words.tags)
            fields: dict[str, object] = {
                "at": at,
                "actor": actor,
                "act": "imported",
                "subject": campaign,
                "before": None,
                "after": digest,
            }
            chain.append(connection, edits, fields)
            stage.path.rename(target)
            sync_folder(target.parent)

    def of(self, campaign: str) -> tuple[Path, str]:
        """Return the folder of an imported campaign and the digest of its list of files.

        Raises
        ------
        NotFoundError
            No campaign of this name was imported.
        """
        with self._database.reading() as connection:
            row = connection.execute(
                select(imports).where(imports.c.campaign == campaign)
            ).one_or_none()
        if row is None:
            raise NotFoundError("was not imported", part=f"campaign {campaign}")
        return self.folder(row.number), row.digest

    def numbers(self) -> dict[int, str]:
        """Return the campaigns that were imported, by the numbers of their imports."""
        with self._database.reading() as connection:
            return {row.number: row.campaign for row in connection.execute(select(imports))}

    def folder(self, number: int) -> Path:
        """Return where the files of an import are."""
        return self._shots / f"i{number:04d}"

    def _claimed(self, last: int) -> Stage:
        """Create the folder of the next number that is free on disk and in the catalogue."""
        while True:
            there = (_FOLDER.fullmatch(path.name) for path in self._shots.iterdir())
            number = max([last, *(int(match[1]) for match in there if match)]) + 1
            path = self._shots / f".i{number:04d}.partial"
            try:
                path.mkdir(FOLDER_MODE)
            except FileExistsError:
                continue
            return Stage(number, path)


def add_rows(
    connection: Connection,
    stage: Stage,
    common: Mapping[str, object],
    found: Sequence[ImportedShot],
    first: int,
) -> None:
    """Add the shots of an import with their tags and results, numbered from `first`."""
    numbered = list(enumerate(found, start=first))
    last = first + len(numbered) - 1
    rows = [{"number": number, **common, **_row(stage, shot)} for number, shot in numbered]
    connection.execute(insert(shots), rows)
    note(connection, shots, shots.c.number.between(first, last))
    tags = [
        {"tag": tag, "shot": number} for number, shot in numbered for tag in sorted(set(shot.tags))
    ]
    if tags:
        connection.execute(insert(shot_tags), tags)
        note(connection, shot_tags, shot_tags.c.shot.between(first, last))
    measured = [
        {"shot": number, "number": 1, "digest": sha256(_first_result(stage, shot))}
        for number, shot in numbered
        if shot.state is ShotState.ANALYSED
    ]
    if measured:
        connection.execute(insert(results), measured)
        note(connection, results, results.c.shot.between(first, last))


def _first_result(stage: Stage, shot: ImportedShot) -> Path:
    return stage.path / stage.shot(shot.number) / "result-0001.json"


def _row(stage: Stage, shot: ImportedShot) -> dict[str, object]:
    return {
        "id": stage.shot(shot.number),
        "state": shot.state,
        "outcome": ShotState.STORED,
        "fired": Fired.YES,
        "settings": "null" if shot.settings is None else shot.settings.model_dump_json(),
        "note": shot.note,
        "simulated": int(shot.simulated),
        "configuration": shot.configuration,
        "fired_at": None if shot.fired_at is None else shot.fired_at.isoformat(),
        "frames": shot.frames,
        "failure": shot.failure,
        "failure_code": None if shot.failure is None else RefusedError.code,
        "results": int(shot.state is ShotState.ANALYSED),
        "excluded": shot.excluded,
        "imported_as": shot.number,
        "manifest": sha256(stage.path / stage.shot(shot.number) / "manifest.json"),
    }


def require_own(connection: Connection, campaign: str | None) -> None:
    """Refuse a shot for an imported campaign: it was another apparatus.

    Raises
    ------
    RefusedError
        The campaign was imported.
    """
    query = select(imports.c.number).where(imports.c.campaign == campaign)
    if campaign is not None and connection.execute(query).one_or_none() is not None:
        raise RefusedError(
            "was imported and takes no shots of this rig",
            part=f"campaign {campaign}",
            todo="fire under another name",
        )


def _require_free(connection: Connection, campaign: str) -> None:
    query = select(shots.c.number).where(shots.c.campaign == campaign).limit(1)
    if connection.execute(query).one_or_none() is not None:
        raise RefusedError(
            "there is a campaign of this name",
            part=f"campaign {campaign}",
            todo="import it under another with --name",
        )
