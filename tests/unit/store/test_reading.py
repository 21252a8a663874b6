"""A store that another process owns, looked into."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from sqlalchemy import text

from rigctl.errors import NotFoundError, StoreError
from rigctl.store import ShotRecord, Store, reading
from rigctl.store.sql.database import Database
from tests.unit.store.conftest import sqlite_alone


def test_what_its_owner_writes_is_seen_while_it_runs_and_after_it(
    store: Store, accepted: Callable[..., ShotRecord]
) -> None:
    accepted()
    with reading(store.path, store.address) as reader:
        assert reader.campaigns.one("nylon").shots == 1
        accepted("another")
        assert reader.campaigns.one("nylon").shots == 2
    store.close()
    with reading(store.path, store.address) as reader:
        assert reader.campaigns.one("nylon").shots == 2


def test_a_reader_cannot_write(store: Store) -> None:
    database = Database(store.path / "catalogue.db", address=store.address, writable=False)
    with pytest.raises(StoreError, match=r"read-?only"):
        database.check()
    database.close()


@pytest.mark.parametrize("name", ["what?mode=rwc", "50% #1", "ü b"])
def test_a_store_lies_in_a_folder_of_any_name(tmp_path: Path, name: str) -> None:
    store = Store(tmp_path / name)
    store.check()
    store.close()
    assert (tmp_path / name / "catalogue.db").stat().st_size > 0
    with reading(tmp_path / name) as reader:
        assert reader.campaigns.all() == []


def test_a_folder_without_a_store_is_left_as_it_is(tmp_path: Path) -> None:
    with pytest.raises(NotFoundError, match="holds no catalogue"), reading(tmp_path):
        raise AssertionError("it was opened")
    assert list(tmp_path.iterdir()) == []


@sqlite_alone
def test_a_store_of_a_later_version_is_refused(store: Store) -> None:
    with Database(store.path / "catalogue.db").writing() as connection:
        connection.execute(text("PRAGMA user_version = 99"))
    with pytest.raises(StoreError, match="later version"), reading(store.path):
        raise AssertionError("it was opened")
