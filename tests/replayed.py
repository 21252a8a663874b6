"""Empty catalogues made by repeating what the migrations have once written: no test waits for them.

Tests open a thousand of them. Those of the migrations, and every program that a test starts, go
through the migrations themselves. Statements are written out in SQL once for all.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Connection, create_engine, event

from rigctl.store.sql import database, migrations, postgresql
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


def written_on_a_server(connection: Connection, to: int) -> str:
    """Go through the migrations on an empty schema; return all statements that changed it."""
    statements: list[str] = []

    def note(_on: object, _cursor: object, statement: str, values: object, *_more: object) -> None:
        if not statement.lstrip().upper().startswith("SELECT"):
            assert not values, statement
            statements.append(statement)

    event.listen(connection, "before_cursor_execute", note)
    try:
        upgrade(connection, 0, to)
    finally:
        event.remove(connection, "before_cursor_execute", note)
    return ";\n".join(statements)


class WrittenOut(dict[Any, Any]):
    """Statements in SQL, for whichever catalogue: the library keeps them for each by itself.

    Its keys begin with the dialect of one, an object of its own; those of a kind are all the same.
    """

    def get(self, key: tuple[Any, ...], default: Any = None) -> Any:
        return super().get(key[1:], default)

    def __setitem__(self, key: tuple[Any, ...], statement: Any) -> None:
        super().__setitem__(key[1:], statement)


@pytest.fixture(scope="session", autouse=True)
def statements_written_once() -> Iterator[None]:
    """Let all catalogues of one kind share, in this process, what their statements are in SQL.

    One that is opened asks some twenty things, of which each would take a millisecond to write.
    """
    with pytest.MonkeyPatch.context() as patch:
        for kind in (database, postgresql):
            shared = partial(create_engine, execution_options={"compiled_cache": WrittenOut()})
            patch.setattr(kind, "create_engine", shared)
        yield


@pytest.fixture(scope="session", autouse=True)
def replayed_migrations(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Let this process make new catalogues by replay."""
    statements = written_by_migrations(tmp_path_factory.mktemp("migrated") / "catalogue.sqlite")
    on_a_server: list[str] = []

    def replay(connection: Connection, version: int, to: int) -> None:
        if version != 0 or connection.dialect.name not in {"sqlite", "postgresql"}:
            upgrade(connection, version, to)
        elif connection.dialect.name == "sqlite":
            for statement in statements:
                connection.exec_driver_sql(statement)
        elif on_a_server:
            connection.exec_driver_sql(on_a_server[0])
        else:
            on_a_server.append(written_on_a_server(connection, to))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(migrations, "upgrade", replay)
        yield
