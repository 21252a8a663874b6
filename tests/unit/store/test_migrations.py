"""A catalogue of any earlier form becomes the present one, all at once or not at all."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import Connection

from rigctl.errors import StoreError
from rigctl.store import NewShot, Store
from rigctl.store.sql.migrations import upgrade
from rigctl.store.sql.schema import SCHEMA_VERSION, metadata

AS_FIRST_WRITTEN = """
CREATE TABLE shots (
    number INTEGER NOT NULL, id TEXT NOT NULL, state TEXT NOT NULL, outcome TEXT,
    fired TEXT NOT NULL, settings TEXT NOT NULL, campaign TEXT, note TEXT, actor TEXT NOT NULL,
    simulated INTEGER NOT NULL, configuration TEXT NOT NULL, accepted_at TEXT NOT NULL,
    fired_at TEXT, ended_at TEXT, frames INTEGER, lost INTEGER, failure TEXT, failure_code TEXT,
    results INTEGER DEFAULT '0' NOT NULL, PRIMARY KEY (number), UNIQUE (id)) STRICT;
CREATE INDEX ix_shots_state ON shots (state);
CREATE INDEX ix_shots_campaign ON shots (campaign);
CREATE TABLE idempotency_keys (
    key TEXT NOT NULL, body_hash TEXT NOT NULL, shot INTEGER NOT NULL,
    PRIMARY KEY (key), FOREIGN KEY(shot) REFERENCES shots (number)) STRICT;
CREATE TABLE transitions (
    number INTEGER NOT NULL, at TEXT NOT NULL, before TEXT NOT NULL, after TEXT NOT NULL,
    actor TEXT NOT NULL, reason TEXT NOT NULL, shot TEXT, digest TEXT NOT NULL,
    PRIMARY KEY (number), FOREIGN KEY(shot) REFERENCES shots (id)) STRICT;
CREATE TABLE probe (id INTEGER NOT NULL, monotonic_s REAL NOT NULL, PRIMARY KEY (id)) STRICT;
INSERT INTO shots VALUES (
    1, '20260131-000001', 'stored', 'stored', 'yes',
    '{"pressure_a_kpa":40.0,"pressure_b_kpa":40.0,"offset_mm":6.0}', 'nylon', NULL, 'anna', 1,
    'c0ffee', '2026-01-31T12:00:00+00:00', NULL, NULL, 4, 0, NULL, NULL, 0);
INSERT INTO idempotency_keys VALUES ('key', 'body', 1);
PRAGMA user_version = 1;
"""


def first_catalogue(folder: Path) -> Path:
    folder.mkdir()
    file = sqlite3.connect(folder / "catalogue.db")
    file.executescript(AS_FIRST_WRITTEN)
    file.close()
    return folder / "catalogue.db"


def tables(path: Path) -> set[str]:
    file = sqlite3.connect(path)
    try:
        return {row[0] for row in file.execute("SELECT name FROM sqlite_master WHERE type='table'")}
    finally:
        file.close()


def test_the_migrations_lead_to_the_tables_that_the_program_declares(store: Store) -> None:
    with store._database.reading() as connection:
        assert compare_metadata(MigrationContext.configure(connection), metadata) == []
        assert store._database._version(connection) == SCHEMA_VERSION


def test_a_catalogue_of_the_first_form_keeps_its_shots_and_keys(
    tmp_path: Path, new_shot: Callable[..., NewShot]
) -> None:
    first_catalogue(tmp_path / "data")
    store = Store(tmp_path / "data")
    known, there_before = store.accept("key", "body", new_shot)
    assert (known.id, known.frames, there_before) == ("20260131-000001", 4, True)
    assert store.accept("other", "body", new_shot)[0].number == 2
    assert store.sweeps.sweeps() == []
    store.close()


def test_a_migration_that_fails_leaves_the_catalogue_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = first_catalogue(tmp_path / "data")
    before = tables(path)

    def die_at_the_end(connection: Connection, version: int, to: int) -> None:
        upgrade(connection, version, to)
        raise sqlite3.OperationalError("disk is full")

    with monkeypatch.context() as patched:
        patched.setattr("rigctl.store.sql.migrations.upgrade", die_at_the_end)
        with pytest.raises(StoreError, match="full"):
            Store(tmp_path / "data")
    assert tables(path) == before
    Store(tmp_path / "data").close()
    assert tables(path) > before
