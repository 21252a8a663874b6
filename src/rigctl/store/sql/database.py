"""The catalogue's transactions: one writer at a time, and errors in words.

Without a server it is one SQLite file in write-ahead mode, every commit forced to disk.
"""

from __future__ import annotations

import os
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from sqlalchemy import URL, Connection, Engine, create_engine, event, insert, update
from sqlalchemy.exc import SQLAlchemyError

from rigctl.errors import StoreError
from rigctl.store.durable import FILE_MODE
from rigctl.store.integrity.ledger import Anchor, head
from rigctl.store.integrity.seal import Seal
from rigctl.store.sql import schema

if TYPE_CHECKING:
    from rigctl.store.sql.postgresql import Postgresql


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


WRITER_WAIT_S = 20.0

Sealing = Callable[[Connection, int], Seal]


class Database:
    """A SQLite file, or a schema of a PostgreSQL server; every commit is forced to disk.

    Parameters
    ----------
    path
        The file.
    address
        URL of a PostgreSQL database, in the place of the file.
    busy_timeout_s
        Longest wait for another program's lock, s.
    writable
        False: the file must be there, and `writing` fails.
    migrate
        Whether a catalogue of an earlier form is brought to the present one; otherwise refused.
    sealing
        Given the first transaction and the version found (0: there was none), returns the seal of
        the ledger's entries; None: no guarded row is written.

    Raises
    ------
    StoreError
        The catalogue cannot be opened, or another version of this program wrote it.
    ConfigurationError
        The address cannot be used.
    """

    def __init__(
        self,
        path: Path,
        busy_timeout_s: float = 5.0,
        *,
        address: str | None = None,
        writable: bool = True,
        migrate: bool = True,
        sealing: Sealing | None = None,
    ) -> None:
        self._writer = threading.Lock()
        self._seal: Seal | None = None
        self._server = _server(path, address, busy_timeout_s, writable=writable)
        self.name, self._engine = self._server.name, self._server.engine
        try:
            if writable and migrate:
                self._create_or_refuse(sealing)
            else:
                with self.reading() as connection:
                    version = self._version(connection)
                    self._require_present(version)
                    self._seal = None if sealing is None else sealing(connection, version)
        except BaseException:
            self.close()
            raise

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """Hold the write lock from the first statement; commit at the end, or change nothing.

        Raises
        ------
        StoreError
            The lock was not had within the busy time-out, or the disk refused.
        """
        writer = self._engine.execution_options(seal=self._seal)
        with self._alone(), self._store_errors(), writer.begin() as connection:
            yield connection

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Let one thread write at a time.

        SQLite's own wait polls and is not fair: under load a thread could starve beyond it.
        """
        if not self._writer.acquire(timeout=WRITER_WAIT_S):
            raise StoreError(
                "another thread of this program has been writing for too long",
                part=self.name,
                limit=f"{WRITER_WAIT_S:g} s",
                todo="look at the disk",
            )
        try:
            yield
        finally:
            self._writer.release()

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Read one consistent state without waiting for a writer.

        Raises
        ------
        StoreError
            The file cannot be read.
        """
        reader = self._engine.execution_options(reading=True)
        with self._store_errors(), reader.begin() as connection:
            yield connection

    def check(self) -> None:
        """Commit one row to prove that commits come through; raise `StoreError` if they do not."""
        values = {"id": 1, "monotonic_s": time.monotonic()}
        with self.writing() as connection:
            if connection.execute(update(schema.probe).values(values)).rowcount == 0:
                connection.execute(insert(schema.probe).values(values))

    def copy_to(self, path: Path) -> None:
        """Copy the catalogue as it is at one moment into a SQLite file that is not there.

        Writers do not wait for it.

        Raises
        ------
        StoreError
            The catalogue cannot be read, or the copy not be written.
        """
        with self._store_errors():
            if isinstance(self._server, Sqlite):
                self._server.copy_to(path)
                return
            copy = Database(path)
            try:
                with copy.writing() as target:
                    self._server.copy_rows(target)
            finally:
                copy.close()

    def head(self) -> Anchor | None:
        """Return the head of the ledger; None where it has no entry."""
        with self.reading() as connection:
            return head(connection)

    def integrity(self) -> list[str]:
        """Return what the database itself finds wrong with its file; of a server nothing."""
        with self.reading() as connection:
            return self._server.integrity(connection)

    def own(self) -> bool:
        """Keep other processes from owning the catalogue until `close`; return whether it was free.

        Raises
        ------
        StoreError
            The catalogue cannot be reached.
        """
        with self._store_errors():
            return self._server.own()

    def disown(self) -> None:
        """Let another process own the catalogue. Safe to call twice."""
        with self._store_errors():
            self._server.disown()

    def close(self) -> None:
        """Give up the catalogue and close every connection. Safe to call twice."""
        self._server.disown()
        self._engine.dispose()

    def _create_or_refuse(self, sealing: Sealing | None) -> None:
        with self.writing() as connection:
            version = self._version(connection)
            if version < schema.SCHEMA_VERSION:
                # Loaded here: most starts find a catalogue that lacks nothing.
                from rigctl.store.sql.migrations import upgrade  # noqa: PLC0415

                upgrade(connection, version, schema.SCHEMA_VERSION)
            self._seal = None if sealing is None else sealing(connection, version)

    def _version(self, connection: Connection) -> int:
        version = self._server.version(connection)
        if version > schema.SCHEMA_VERSION:
            raise StoreError(
                "was written by a later version of this program",
                part=self.name,
                value=f"schema {version}",
                limit=f"schema {schema.SCHEMA_VERSION}",
                todo="install the later version, or name another store folder",
            )
        return version

    def _require_present(self, version: int) -> None:
        if version < schema.SCHEMA_VERSION:
            raise StoreError(
                "was written by an earlier version of this program",
                part=self.name,
                value=f"schema {version}",
                limit=f"schema {schema.SCHEMA_VERSION}",
                todo="start `rigctl serve` of this version once, which brings it up to date",
            )

    @contextmanager
    def _store_errors(self) -> Iterator[None]:
        try:
            yield
        except (SQLAlchemyError, sqlite3.Error) as error:
            cause = str(getattr(error, "orig", None) or error).strip()
            todo = next((text for word, text in self._server.todo.items() if word in cause), None)
            raise StoreError(cause.partition("\n")[0], part=self.name, todo=todo) from error


def _server(
    path: Path, address: str | None, busy_timeout_s: float, *, writable: bool
) -> Sqlite | Postgresql:
    if address is None:
        return Sqlite(path, busy_timeout_s, writable=writable)
    # Few installations have a server.
    from rigctl.store.sql.postgresql import Postgresql  # noqa: PLC0415

    return Postgresql(address, busy_timeout_s, writable=writable)
