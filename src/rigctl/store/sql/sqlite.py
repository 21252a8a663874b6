"""The catalogue as one SQLite file in write-ahead mode, every commit forced to disk."""

from __future__ import annotations

import os
import sqlite3
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar

from sqlalchemy import URL, Connection, Engine, create_engine, event

from rigctl.store.durable import FILE_MODE

_DURABLE = ("journal_mode = WAL", "synchronous = FULL", "foreign_keys = ON")


class Sqlite:
    """One file. Write-ahead logging does not work on network file systems: keep it on a local disk.

    Parameters
    ----------
    path
        The file.
    busy_timeout_s
        Longest wait for another program's lock, s.
    writable
        False: the file must be there, and cannot be changed.
    """

    todo: ClassVar[dict[str, str]] = {
        "locked": "end the program that holds the file, then try again",
        "full": "free disk space, then try again",
        "readonly": "give the daemon write access to the file and its folder",
        "unable to open": "give the daemon write access to the folder",
        "malformed": "restore the file from a backup, or rebuild it with `rigctl recover`",
        "not a database": (
            "name another store folder, restore the file from a backup, or rebuild it with "
            "`rigctl recover`"
        ),
    }

    def __init__(self, path: Path, busy_timeout_s: float, *, writable: bool) -> None:
        self.name = str(path)
        if writable:
            # The library would create it with the rights that the umask leaves.
            with suppress(OSError):
                os.close(os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, FILE_MODE))
        self.engine = _engine(path, busy_timeout_s, writable=writable)

    def version(self, connection: Connection) -> int:
        """Return the number of the last migration of the catalogue; 0: there is none."""
        return int(connection.exec_driver_sql("PRAGMA user_version").scalar_one())

    def integrity(self, connection: Connection) -> list[str]:
        """Return what SQLite finds wrong with pages, indexes, types and references."""
        found = [str(row[0]) for row in connection.exec_driver_sql("PRAGMA integrity_check")]
        lost = connection.exec_driver_sql("PRAGMA foreign_key_check").all()
        named = [f"row {row[1]} of {row[0]} refers to no row of {row[2]}" for row in lost]
        return [line for line in found if line != "ok"] + named

    def own(self) -> bool:
        """Return true: the lock beside the file has excluded other owners already."""
        return True

    def disown(self) -> None:
        """Do nothing: the lock beside the file is given up by its holder."""

    def copy_to(self, path: Path) -> None:
        """Copy the catalogue as it is at one moment; a reader holds up no writer."""
        with self.engine.connect() as connection:
            source: Any = connection.connection.driver_connection
            target = sqlite3.connect(path)
            try:
                source.backup(target)
            finally:
                target.close()
        with path.open("rb") as file:
            os.fsync(file.fileno())


def _engine(path: Path, busy_timeout_s: float, *, writable: bool) -> Engine:
    address = URL.create("sqlite", database=str(path))
    if not writable:
        address = address.set(database=path.as_uri(), query={"mode": "ro", "uri": "true"})
    engine = create_engine(address, connect_args={"timeout": busy_timeout_s})

    @event.listens_for(engine, "connect")
    def _configure(connection: Any, _record: object) -> None:  # noqa: ANN401
        # The driver would begin a transaction only at the first change, too late for a claim.
        connection.isolation_level = None
        for pragma in _DURABLE if writable else ():
            connection.execute(f"PRAGMA {pragma}")

    @event.listens_for(engine, "begin")
    def _begin(connection: Connection) -> None:
        reading = connection.get_execution_options().get("reading", False)
        connection.exec_driver_sql("BEGIN" if reading else "BEGIN IMMEDIATE")

    return engine
