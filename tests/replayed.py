"""Empty catalogues made by repeating what the migrations have once written: no test waits for them.

Tests open a thousand of them. Those of the migrations, and every program that a test starts, go
through the migrations themselves.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import Connection

from rigctl.store.sql import migrations
from rigctl.store.sql.database import Database
from rigctl.store.sql.migrations.upgrade import upgrade


def written_by_migrations(path: Path) -> list[str]:
    """Return the statements that make an empty catalogue as the migrations leave it."""
    Database(path).close()
    catalogue = sqlite3.connect(path)
    try:
        made = "SELECT sql FROM sqlite_master WHERE sql IS NOT NULL AND name NOT LIKE 'sqlite_%'"
        statements = [str(sql) for (sql,) in catalogue.execute(made)]
        ((last,),) = catalogue.execute("SELECT version_num FROM alembic_version")
        ((version,),) = catalogue.execute("PRAGMA user_version")
    finally:
        catalogue.close()
    mark = f"INSERT INTO alembic_version VALUES ('{last}')"
    return [*statements, mark, f"PRAGMA user_version = {version}"]


@pytest.fixture(scope="session", autouse=True)
def replayed_migrations(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Let this process make new SQLite catalogues by replay."""
    statements = written_by_migrations(tmp_path_factory.mktemp("migrated") / "catalogue.sqlite")

    def replay(connection: Connection, version: int, to: int) -> None:
        if version != 0 or connection.dialect.name != "sqlite":
            upgrade(connection, version, to)
            return
        for statement in statements:
            connection.exec_driver_sql(statement)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(migrations, "upgrade", replay)
        yield
