"""What is particular to a catalogue on a PostgreSQL server."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from sqlalchemy import create_engine

from rigctl.errors import ConfigurationError, NotFoundError, StoreError
from rigctl.exchange.contents import read_contents
from rigctl.exchange.importing import import_campaign
from rigctl.measuring.measured import measured_files, request
from rigctl.model.computing import fit_job
from rigctl.reports.campaign import report_job
from rigctl.store import ShotRecord, ShotState, Store
from tests.unit.analysis.model.tabulated import contacts
from tests.unit.store.conftest import perform


def silent(_text: str, _share: float | None) -> None:
    """Say nothing."""


on_a_server = pytest.mark.parametrize("backend", ["postgresql"], indirect=True)


@on_a_server
def test_two_folders_cannot_own_one_catalogue(store: Store, tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    shutil.copy(store.path / "audit.key", tmp_path / "elsewhere")
    with pytest.raises(StoreError, match=r"postgresql\+psycopg.*another process owns the store"):
        Store(tmp_path / "elsewhere", database=store.address)
    store.close()
    Store(tmp_path / "elsewhere", database=store.address).close()


@on_a_server
def test_a_catalogue_that_another_program_holds_is_an_error_in_bounded_time(
    store: Store, accepted: Callable[..., ShotRecord]
) -> None:
    shot = accepted()
    other = Store(store.path, database=store.address, shared=True)
    with other._database.writing():
        with pytest.raises(StoreError, match=r"lock timeout.*end the program"):
            store.move(shot.id, ShotState.FIRING)
        assert store.shot(shot.id).state is ShotState.ACCEPTED
    other.close()
    assert store.move(shot.id, ShotState.FIRING).state is ShotState.FIRING


@on_a_server
def test_a_catalogue_of_a_later_version_is_refused_with_both_versions(store: Store) -> None:
    perform(store, "UPDATE alembic_version SET version_num = '0099'")
    store.close()
    with pytest.raises(StoreError, match=r"later version.*schema 99.*schema 6"):
        Store(store.path, database=store.address)


@on_a_server
def test_a_server_that_went_away_is_an_error_and_its_return_is_noticed(
    store: Store, accepted: Callable[..., ShotRecord], server: str
) -> None:
    shot = accepted()
    engine = create_engine(server.replace("postgresql:", "postgresql+psycopg:"))
    with engine.connect() as connection:
        connection.exec_driver_sql(
            "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid() "
            "AND datname IS NOT NULL"
        )
    engine.dispose()
    assert store.shot(shot.id).state is ShotState.ACCEPTED


@on_a_server
def test_commits_are_forced_to_disk_whatever_the_database_says(store: Store) -> None:
    with store._database.writing() as connection:
        assert connection.exec_driver_sql("SHOW synchronous_commit").scalar_one() == "on"


@on_a_server
def test_jobs_look_for_campaigns_on_the_server(store: Store, tmp_path: Path) -> None:
    contents = read_contents(contacts(tmp_path / "tables", 20, 62), silent)
    import_campaign(store, contents, "anna", name="tables", progress=silent)
    asked = request("tables", measured_files(store, "tables"), (), store)
    assert fit_job(asked, silent)["shots"] == 20
    place = {"store": str(store.path), "database": store.address}
    with pytest.raises(NotFoundError, match="no such campaign"):
        report_job({**place, "campaign": "steel"}, silent)


def test_an_address_that_is_none_is_refused_in_words(tmp_path: Path) -> None:
    for address in ("mysql://host/database", "nonsense"):
        with pytest.raises(ConfigurationError, match=r"store\.database"):
            Store(tmp_path / "data", database=address)


def test_a_server_that_does_not_answer_is_named_without_its_password(tmp_path: Path) -> None:
    pytest.importorskip("psycopg")
    address = f"postgresql://anna:secret@/lab?host={tmp_path}"
    with pytest.raises(StoreError, match="start the server") as found:
        Store(tmp_path / "data", database=address)
    assert "secret" not in str(found.value)
