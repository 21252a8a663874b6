"""The store as a whole: one owner, durable settings, and errors that say what to do."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest

from rigctl.errors import StoreError
from rigctl.store import NewShot, ShotRecord, ShotState, Store
from rigctl.store.sql.schema import metadata
from tests.unit.store.conftest import sqlite_alone


def pragma(folder: Path, name: str) -> object:
    file = sqlite3.connect(folder / "catalogue.db")
    try:
        return file.execute(f"PRAGMA {name}").fetchone()[0]
    finally:
        file.close()


def test_a_second_owner_is_refused_until_the_first_has_closed(store: Store) -> None:
    with pytest.raises(StoreError, match="another process owns the store"):
        Store(store.path, database=store.address)
    store.close()
    Store(store.path, database=store.address).close()


@sqlite_alone
def test_the_catalogue_is_written_ahead_and_its_tables_are_strict(
    store: Store, tmp_path: Path
) -> None:
    assert pragma(tmp_path / "data", "journal_mode") == "wal"
    file = sqlite3.connect(tmp_path / "data" / "catalogue.db")
    found = file.execute("PRAGMA table_list").fetchall()
    file.close()
    ours = {row[1]: row[5] for row in found if not row[1].startswith("sqlite_")}
    assert ours.pop("alembic_version") == 0
    assert set(ours) == set(metadata.tables)
    assert set(ours.values()) == {1}


@sqlite_alone
def test_every_commit_is_forced_to_disk_and_keys_refer_to_shots(store: Store) -> None:
    with store._database.writing() as connection:
        assert connection.exec_driver_sql("PRAGMA synchronous").scalar_one() == 2
        assert connection.exec_driver_sql("PRAGMA foreign_keys").scalar_one() == 1


@sqlite_alone
def test_a_catalogue_of_a_later_version_is_refused_with_both_versions(
    store: Store, tmp_path: Path
) -> None:
    store.close()
    file = sqlite3.connect(tmp_path / "data" / "catalogue.db")
    file.execute("PRAGMA user_version = 99")
    file.close()
    with pytest.raises(StoreError, match=r"schema 99.*schema 6"):
        Store(tmp_path / "data")
    assert pragma(tmp_path / "data", "user_version") == 99


def test_a_file_that_is_no_catalogue_is_refused(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "catalogue.db").write_bytes(b"these are not the tables" * 100)
    with pytest.raises(StoreError, match=r"not a database.*another store folder"):
        Store(tmp_path / "data")


def test_a_folder_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "data").write_text("in the way")
    with pytest.raises(StoreError, match="cannot be written"):
        Store(tmp_path / "data")


@sqlite_alone
def test_a_locked_catalogue_is_an_error_in_bounded_time(
    store: Store, accepted: Callable[..., ShotRecord], tmp_path: Path
) -> None:
    shot = accepted()
    holder = sqlite3.connect(tmp_path / "data" / "catalogue.db", isolation_level=None)
    holder.execute("BEGIN IMMEDIATE")
    with pytest.raises(StoreError, match=r"locked.*end the program"):
        store.move(shot.id, ShotState.FIRING)
    with pytest.raises(StoreError, match="locked"):
        store.check()
    assert store.shot(shot.id).state is ShotState.ACCEPTED
    holder.execute("ROLLBACK")
    holder.close()
    store.check()
    assert store.move(shot.id, ShotState.FIRING).state is ShotState.FIRING


@sqlite_alone
def test_a_full_catalogue_is_an_error_that_says_what_to_free(
    store: Store, new_shot: Callable[..., NewShot]
) -> None:
    with store._database.reading() as connection:
        pages = connection.exec_driver_sql("PRAGMA page_count").scalar_one()
        connection.exec_driver_sql(f"PRAGMA max_page_count = {pages}")

    def fill() -> None:
        for n in range(1000):
            store.accept(f"key {n}", "body", lambda: new_shot(note="x" * 500))

    with pytest.raises(StoreError, match=r"full.*free disk space"):
        fill()


def test_a_folder_that_went_away_fails_the_check(store: Store, tmp_path: Path) -> None:
    store.check()
    (tmp_path / "data").rename(tmp_path / "elsewhere")
    with pytest.raises(StoreError, match="cannot be written"):
        store.check()
    with pytest.raises(StoreError):
        store.free_mb()


def test_free_space_is_given_in_millions_of_bytes(tmp_path: Path) -> None:
    store = Store(tmp_path / "data", free_bytes=lambda folder: 123_000_000)
    assert store.free_mb() == 123.0
    store.close()
