"""The SQLite file: durable settings, one writer at a time, and errors in words."""

from __future__ import annotations

import os
import sqlite3
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import URL, Connection, Engine, create_engine, event
from sqlalchemy.exc import SQLAlchemyError

from rigctl.errors import StoreError
from rigctl.store import schema

_TODO = {
    "locked": "end the program that holds the file, then arm again",
    "full": "free disk space, then arm again",
    "readonly": "give the daemon write access to the file and its folder",
    "unable to open": "give the daemon write access to the folder",
    "malformed": "restore the file from a backup; the shot folders are whole without it",
    "not a database": "name another store folder, or restore the file from a backup",
}

WRITER_WAIT_S = 20.0

_DURABLE = ("journal_mode = WAL", "synchronous = FULL", "foreign_keys = ON")


class Database:
    """One SQLite file in write-ahead mode, every commit forced to disk (synchronous FULL).

    Write-ahead logging does not work on network file systems: keep the store on a local disk.

    Parameters
    ----------
    path
        The file.
    busy_timeout_s
        Longest wait for another program's lock, s.
    writable
        False: the file must be there, and `writing` fails.
    migrate
        Whether a catalogue of an earlier form is brought to the present one; otherwise refused.

    Raises
    ------
    StoreError
        The file cannot be opened, or another version of this program wrote it.
    """

    def __init__(
        self,
        path: Path,
        busy_timeout_s: float = 5.0,
        *,
        writable: bool = True,
        migrate: bool = True,
    ) -> None:
        self.name = str(path)
        self._writer = threading.Lock()
        self._engine = _engine(path, busy_timeout_s, writable=writable)
        try:
            if writable and migrate:
                self._create_or_refuse()
            else:
                with self.reading() as connection:
                    self._require_present(self._version(connection))
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
        with self._alone(), self._in_words(), self._engine.begin() as connection:
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
        with self._in_words(), reader.begin() as connection:
            yield connection

    def check(self) -> None:
        """Commit one row to prove that commits come through; raise `StoreError` if they do not."""
        with self.writing() as connection:
            connection.exec_driver_sql(
                "INSERT OR REPLACE INTO probe (id, monotonic_s) VALUES (1, ?)", (time.monotonic(),)
            )

    def copy_to(self, path: Path) -> None:
        """Copy the catalogue as it is at one moment into a file that is not there.

        Nobody waits for it: in write-ahead mode a reader holds up no writer.

        Raises
        ------
        StoreError
            The catalogue cannot be read, or the copy not be written.
        """
        with self._in_words(), self._engine.connect() as connection:
            source: Any = connection.connection.driver_connection
            target = sqlite3.connect(path)
            try:
                source.backup(target)
            finally:
                target.close()
        with path.open("rb") as file:
            os.fsync(file.fileno())

    def close(self) -> None:
        """Close every connection. Safe to call twice."""
        self._engine.dispose()

    def _create_or_refuse(self) -> None:
        with self.writing() as connection:
            version = self._version(connection)
            if version < schema.SCHEMA_VERSION:
                # Loaded here: most starts find a catalogue that lacks nothing.
                from rigctl.store.migrations import upgrade  # noqa: PLC0415

                upgrade(connection, version, schema.SCHEMA_VERSION)

    def _version(self, connection: Connection) -> int:
        version = int(connection.exec_driver_sql("PRAGMA user_version").scalar_one())
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
    def _in_words(self) -> Iterator[None]:
        try:
            yield
        except (SQLAlchemyError, sqlite3.Error) as error:
            cause = str(getattr(error, "orig", None) or error)
            todo = next((text for word, text in _TODO.items() if word in cause), None)
            raise StoreError(cause, part=self.name, todo=todo) from error


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
