"""From folders to a catalogue: all of it in one transaction, or none."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from sqlalchemy import Connection

from rigctl.errors import CatalogueLostError, NotFoundError, RefusedError, StoreError
from rigctl.rebuilding.filling import fill
from rigctl.rebuilding.found import Found, look
from rigctl.store.integrity.seal import Seal, new_seal, read_seal
from rigctl.store.ownership import owned
from rigctl.store.sql.database import Database
from rigctl.store.sql.opened import open_catalogue

_BROKEN = ("malformed", "not a database")


@dataclass(slots=True)
class Rebuilt:
    """What a catalogue was rebuilt from.

    Attributes
    ----------
    shots, imports, sweeps
        How many are in it again; shots are those that were fired here.
    open
        Shots that had not ended: whether they fired is not known, and a person has to look.
    without_key
        Shots whose manifests are older than their idempotency keys: who repeats a request under
        one of these fires again.
    missing
        How many numbers of shots are not on disk: they ended without frames, before such ends
        were kept beside the shots.
    unreadable
        Folders and files that could not be read, each with why; they are not in the catalogue.
    kept
        Where the former catalogue was put; None: there was none.
    """

    shots: int = 0
    imports: int = 0
    sweeps: int = 0
    open: list[str] = field(default_factory=list)
    without_key: list[str] = field(default_factory=list)
    missing: int = 0
    unreadable: list[str] = field(default_factory=list)
    kept: str | None = None


def rebuild(root: Path, address: str | None, now: datetime | None = None) -> Rebuilt:
    """Build the catalogue of a store again that is lost, damaged or older than its shots.

    A damaged file is kept under another name. Nothing beside it is changed.

    Raises
    ------
    NotFoundError
        There is no shot to build it from.
    RefusedError
        The catalogue is whole.
    StoreError
        Another process owns the store, or the disk refuses; nothing has changed.
    """
    at = now or datetime.now(UTC)
    path = root / "catalogue.db"
    found = look(root)
    if not (found.shots or found.imports or found.unreadable):
        raise NotFoundError("holds no shots", part=str(root), todo="start `rigctl serve`")
    with owned(root):
        _require_lost(root, address)
        found = look(root)
        rebuilt = _summary(found)
        rebuilt.kept = None if address else _put_aside(path, at)

        def begin(connection: Connection, version: int) -> Seal:
            if version:
                raise StoreError(
                    "the catalogue on the server is there, and no file that could be put aside",
                    part="store.database",
                    todo="name an empty schema or database, then recover again",
                )
            seal = read_seal(root) or new_seal(root)
            fill(connection, seal, found, at)
            return seal

        Database(path, address=address, sealing=begin).close()
    return rebuilt


def _require_lost(root: Path, address: str | None) -> None:
    try:
        catalogue = open_catalogue(root, address, 5.0, migrate=True)
    except CatalogueLostError:
        return
    except StoreError as error:
        if any(word in error.what for word in _BROKEN):
            return
        raise
    try:
        whole = not catalogue.integrity()
    finally:
        catalogue.close()
    if whole:
        raise RefusedError(
            "the catalogue is whole and knows every shot",
            part=catalogue.name,
            todo="look with `rigctl verify`; nothing is to be recovered",
        )


def _put_aside(path: Path, at: datetime) -> str | None:
    """Rename the former catalogue with what SQLite keeps beside it; return its new name."""
    aside = path.with_name(f"{path.name}.lost-{at:%Y%m%dT%H%M%S}")
    for ending in ("-wal", "-shm", ""):
        part = path.with_name(path.name + ending)
        if part.exists():
            part.rename(aside.with_name(aside.name + ending))
    return str(aside) if aside.exists() else None


def _summary(found: Found) -> Rebuilt:
    last = max((shot.number for shot in found.shots), default=0)
    imported = sum(len(campaign.shots) for campaign in found.imports)
    return Rebuilt(
        shots=len(found.shots),
        imports=len(found.imports),
        sweeps=len(found.sweeps),
        open=[str(shot.row["id"]) for shot in found.shots if shot.row["outcome"] is None],
        without_key=[str(shot.row["id"]) for shot in found.shots if shot.request is None],
        missing=max(0, last - len(found.shots) - imported),
        unreadable=found.unreadable,
    )
