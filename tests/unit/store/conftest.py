"""One store in a folder of its own, on either kind of catalogue, and shots to put into it.

Every test that takes `store` runs on a SQLite file and on a PostgreSQL server, unless it is marked
`sqlite_alone` because it looks into the file itself.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import create_engine

from rigctl.cameras.frames import FrameSequence
from rigctl.settings import ShotSettings
from rigctl.store import NewShot, ShotRecord, Store
from tests.unit.store import postgresql_server
from tests.unit.store.postgresql_server import binaries

sqlite_alone = pytest.mark.parametrize("backend", ["sqlite"], indirect=True)


@pytest.fixture(scope="session")
def server() -> Iterator[str]:
    if binaries() is None:
        pytest.skip("no PostgreSQL server is installed")
    pytest.importorskip("psycopg")
    with postgresql_server.server() as address:
        yield address


@pytest.fixture(params=["sqlite", "postgresql"])
def backend(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def database(backend: str, request: pytest.FixtureRequest) -> Iterator[str | None]:
    """Return the address of an empty catalogue; None: the file in the store's folder."""
    if backend == "sqlite":
        yield None
        return
    address = request.getfixturevalue("server")
    engine = create_engine(address.replace("postgresql:", "postgresql+psycopg:"))
    schema = f"s{uuid.uuid4().hex}"
    with engine.begin() as connection:
        connection.exec_driver_sql(f"CREATE SCHEMA {schema}")
    engine.dispose()
    yield f"{address}&options=-csearch_path%3D{schema}"


@pytest.fixture
def store(tmp_path: Path, database: str | None) -> Iterator[Store]:
    opened = Store(tmp_path / "data", database=database, busy_timeout_s=0.05)
    yield opened
    opened.close()


@pytest.fixture
def new_shot() -> Callable[..., NewShot]:
    def make(**changes: object) -> NewShot:
        fields = {
            "settings": ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=41.0, offset_mm=6.0),
            "campaign": "nylon",
            "note": None,
            "actor": "anna",
            "simulated": True,
            "configuration": "c0ffee",
            "accepted_at": datetime(2026, 1, 31, 23, 59, tzinfo=UTC),
        }
        return NewShot(**{**fields, **changes})

    return make


@pytest.fixture
def accepted(store: Store, new_shot: Callable[..., NewShot]) -> Callable[..., ShotRecord]:
    def accept(key: str = "key", **changes: object) -> ShotRecord:
        return store.accept(key, "body", lambda: new_shot(**changes))[0]

    return accept


@pytest.fixture
def frames() -> FrameSequence:
    chance = np.random.default_rng(7)
    return FrameSequence(
        pixels=chance.integers(0, 256, (5, 16, 24), dtype=np.uint8),
        times_s=np.array([0.1, 0.101, 0.102, 0.104, 0.105]),
        sequence=np.array([100, 101, 102, 104, 105], dtype=np.int64),
        lost=(103,),
        source="stand-in",
    )


def perform(store: Store, statement: str) -> None:
    """Change the catalogue behind the program's back."""
    with store._database.writing() as connection:
        connection.exec_driver_sql(statement)


def without_guard(store: Store, table: str) -> None:
    """Take away what keeps a table append-only, as somebody with all rights could."""
    if store.address is not None:
        perform(store, f"DROP TRIGGER {table}_append_only ON {table}")
        return
    for act in ("update", "delete"):
        perform(store, f"DROP TRIGGER {table}_no_{act}")
