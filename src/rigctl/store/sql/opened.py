"""Opens a catalogue for its store: begun where nothing was lost, sealed by the store's key."""

from __future__ import annotations

from pathlib import Path

from sqlalchemy import Connection, func, select

from rigctl.errors import CatalogueLostError
from rigctl.store.integrity import ledger
from rigctl.store.integrity.lost import require_latest, require_no_shots
from rigctl.store.integrity.seal import FILE_NAME, Seal, new_seal, read_seal
from rigctl.store.sql.database import Database
from rigctl.store.sql.schema import shots

SEALED = 6
"""From this version on a catalogue has a ledger."""


def open_catalogue(
    folder: Path, address: str | None, busy_timeout_s: float, *, migrate: bool
) -> Database:
    """Open the catalogue of a store's folder, or begin it where there are no shots either.

    Raises
    ------
    StoreError
        As `Database`; as `CatalogueLostError` it is missing or older than the shots, or the key
        of its audit is missing or another one.
    """
    path = folder / "catalogue.db"
    if address is None and not (path.exists() and path.stat().st_size):
        # SQLite would take an empty file for a new catalogue, and remove what is left of the old.
        require_no_shots(folder, str(path))

    def sealing(connection: Connection, version: int) -> Seal:
        name = "the catalogue on the server" if address else str(path)
        if version == 0:
            require_no_shots(folder, name)
        last = connection.execute(select(func.max(shots.c.number))).scalar_one() or 0
        require_latest(folder, name, last)
        return _sealed(connection, version, folder)

    return Database(path, busy_timeout_s, address=address, migrate=migrate, sealing=sealing)


def _sealed(connection: Connection, version: int, folder: Path) -> Seal:
    seal = read_seal(folder)
    if version < SEALED:
        seal = seal or new_seal(folder)
        ledger.begin(connection, seal)
        return seal
    if seal is None:
        raise CatalogueLostError(
            "the key of the audit is missing",
            part=str(folder / FILE_NAME),
            todo="restore the file from a backup, or rebuild the catalogue with `rigctl recover`",
        )
    ledger.require_own(connection, seal)
    return seal
