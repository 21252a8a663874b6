"""The catalogue's transactions: one writer at a time, and errors in words."""

from __future__ import annotations

import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import Connection, insert, update
from sqlalchemy.exc import SQLAlchemyError

from rigctl.errors import StoreError
from rigctl.store.integrity.ledger import Anchor, head
from rigctl.store.integrity.seal import Seal
from rigctl.store.sql import schema
from rigctl.store.sql.sqlite import Sqlite

if TYPE_CHECKING:
    from rigctl.store.sql.postgresql import Postgresql

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
