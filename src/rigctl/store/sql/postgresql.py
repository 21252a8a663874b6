"""The catalogue in a PostgreSQL database, or in one schema of it."""

from __future__ import annotations

from typing import Any, ClassVar

from sqlalchemy import (
    URL,
    Connection,
    Engine,
    create_engine,
    event,
    insert,
    inspect,
    make_url,
    select,
)
from sqlalchemy.exc import ArgumentError

from rigctl.errors import ConfigurationError, StoreError
from rigctl.store.sql.schema import metadata

CONNECT_WAIT_S = 5
_CHUNK = 5000

_LOCK = "hashtext('rigctl ' || current_schema())"
"""First half of the keys of advisory locks: one catalogue a schema."""
_WRITER, _OWNER = 1, 2


class Postgresql:
    """A schema of a server that forces commits to disk; writers take turns, as in SQLite.

    Parameters
    ----------
    address
        URL of the database; `postgresql://` uses the driver psycopg.
    busy_timeout_s
        Longest wait for another program's transaction, s.
    writable
        False: it can only be read.

    Raises
    ------
    ConfigurationError
        The address is none of PostgreSQL, or the extra `postgresql` is not installed.
    """

    todo: ClassVar[dict[str, str]] = {
        "lock timeout": "end the program that holds the catalogue, then try again",
        "No space left": "free disk space on the server, then try again",
        "could not extend": "free disk space on the server, then try again",
        "connection": "start the server, or correct store.database",
        "password": "correct the password, best in a file that PGPASSFILE names",
        "does not exist": "create the database, then start again",
        "permission denied": "give the daemon's user rights on the schema",
        "read-only": "give the daemon's user rights on the schema",
    }

    def __init__(self, address: str, busy_timeout_s: float, *, writable: bool) -> None:
        url = _url(address)
        self.name = url.render_as_string(hide_password=True)
        self.engine = _engine(url, busy_timeout_s, writable=writable)
        self._owner: Connection | None = None

    def version(self, connection: Connection) -> int:
        """Return the number of the last migration of the catalogue; 0: there is none.

        Raises
        ------
        StoreError
            The server does not force commits to disk.
        """
        if connection.exec_driver_sql("SHOW fsync").scalar_one() != "on":
            raise StoreError(
                "the server does not force commits to disk",
                part=self.name,
                value="fsync = off",
                limit="fsync = on",
                todo="correct the server's configuration",
            )
        if not inspect(connection).has_table("alembic_version"):
            return 0
        found = connection.exec_driver_sql("SELECT version_num FROM alembic_version")
        return int(found.scalar_one_or_none() or 0)

    def integrity(self, _: Connection) -> list[str]:
        """Return nothing: a server checks its own pages."""
        return []

    def own(self) -> bool:
        """Take the catalogue for this process until `disown`; return whether it was free."""
        connection = self.engine.execution_options(isolation_level="AUTOCOMMIT").connect()
        ask = f"SELECT pg_try_advisory_lock({_LOCK}, {_OWNER})"
        if not connection.exec_driver_sql(ask).scalar_one():
            connection.close()
            return False
        self._owner = connection
        return True

    def disown(self) -> None:
        """Let another process own the catalogue. Safe to call twice."""
        if self._owner is not None:
            self._owner.invalidate()
            self._owner.close()
            self._owner = None

    def copy_rows(self, target: Connection) -> None:
        """Copy all rows as they are at one moment into tables of the same schema."""
        with self.engine.execution_options(reading=True).begin() as source:
            for table in metadata.sorted_tables:
                rows = source.execute(select(table)).mappings()
                while chunk := rows.fetchmany(_CHUNK):
                    target.execute(insert(table), [dict(row) for row in chunk])


def _url(address: str) -> URL:
    try:
        url = make_url(address)
    except ArgumentError as error:
        raise ConfigurationError(
            "is no address of a database", part="store.database", todo="write postgresql://..."
        ) from error
    if url.drivername not in {"postgresql", "postgresql+psycopg"}:
        raise ConfigurationError(
            "is no address of PostgreSQL",
            part="store.database",
            value=repr(url.drivername),
            limit="postgresql://user@host/database",
            todo="leave it out for a SQLite file in the store's folder",
        )
    return url.set(drivername="postgresql+psycopg")


def _engine(url: URL, busy_timeout_s: float, *, writable: bool) -> Engine:
    try:
        engine = create_engine(
            url, pool_pre_ping=True, connect_args={"connect_timeout": CONNECT_WAIT_S}
        )
    except ImportError as error:
        raise ConfigurationError(
            f"needs what is not installed: {error}",
            part="store.database",
            todo="install rigctl with the extra `postgresql`",
        ) from error

    @event.listens_for(engine, "connect")
    def _configure(connection: Any, _record: object) -> None:  # noqa: ANN401
        # A commit returns when it is on disk, whatever the server's default.
        connection.execute("SET synchronous_commit TO on")
        connection.execute(f"SET lock_timeout TO {max(1, round(busy_timeout_s * 1000))}")
        connection.commit()

    @event.listens_for(engine, "begin")
    def _begin(connection: Connection) -> None:
        options = connection.get_execution_options()
        if options.get("isolation_level") == "AUTOCOMMIT":
            return
        if options.get("reading", False) or not writable:
            begin = "SET TRANSACTION ISOLATION LEVEL REPEATABLE READ READ ONLY"
        else:
            begin = f"SELECT pg_advisory_xact_lock({_LOCK}, {_WRITER})"
        connection.exec_driver_sql(begin)

    return engine
