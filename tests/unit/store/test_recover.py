"""A lost catalogue is never begun anew in silence, and can be built again from the folders."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import pytest

from rigctl.cameras.frames import FrameSequence
from rigctl.cli import NOT_FOUND, run
from rigctl.errors import KeyReusedError, NotFoundError, RefusedError, StoreError
from rigctl.exchange.contents import read_contents
from rigctl.exchange.importing import import_campaign
from rigctl.rebuilding import rebuild
from rigctl.rig.recovery import close_open_shots
from rigctl.settings import ShotSettings
from rigctl.store import (
    Change,
    Fired,
    NewShot,
    NewSweep,
    ShotRecord,
    ShotState,
    Store,
    SweepState,
    reading,
)
from rigctl.store.integrity.verifying import verify_store
from tests.unit.analysis.model.tabulated import contacts
from tests.unit.store.conftest import sqlite_alone

NOW = datetime(2026, 1, 31, 12, 0, tzinfo=UTC)
Fire = Callable[..., ShotRecord]


def silent(_text: str, _share: float | None) -> None:
    """Say nothing."""


def refuse() -> NewShot:
    raise AssertionError("a used key was taken for a fresh one")


@pytest.fixture
def fire(store: Store, new_shot: Callable[..., NewShot], frames: FrameSequence) -> Fire:
    """Carry a shot to `analysed`, as the rig and the analysis do."""

    def fired(key: str, **changes: object) -> ShotRecord:
        shot = store.accept(key, f"body of {key}", lambda: new_shot(**changes))[0].id
        store.move(shot, ShotState.FIRING, Change(fired=Fired.UNKNOWN))
        confirmed = store.move(shot, ShotState.CAPTURING, Change(fired=Fired.YES, fired_at=NOW))
        store.keep_frames(confirmed, frames, {"program": "rigctl"})
        store.move(shot, ShotState.STORED, Change(frames=5, lost=1))
        store.move(shot, ShotState.ANALYSING)
        number = store.folders.add_result(shot, {"e": 0.7})
        return store.move(shot, ShotState.ANALYSED, Change(results=number))

    return fired


def lose(store: Store, how: str) -> None:
    """Take the catalogue away as a disk or a person does."""
    store.close()
    for part in ("catalogue.db-wal", "catalogue.db-shm"):
        (store.path / part).unlink(missing_ok=True)
    catalogue = store.path / "catalogue.db"
    if how == "deleted":
        catalogue.unlink()
    elif how == "cut to nothing":
        catalogue.write_bytes(b"")
    else:
        catalogue.write_bytes(b"these are not the tables" * 1000)


def findings(store: Store) -> list[str]:
    with reading(store.path, store.address) as reader:
        return [f"{each.part}: {each.what}" for each in verify_store(reader, silent).faults]


@sqlite_alone
@pytest.mark.parametrize("how", ["deleted", "cut to nothing", "overwritten"])
def test_what_was_fired_is_there_again_and_no_used_key_fires(
    store: Store, fire: Fire, how: str, accepted: Fire
) -> None:
    before = [fire("first"), fire("second", campaign="brass", note="dry")]
    given_up = accepted("third")
    why = Change(fired=Fired.NO, ended_at=NOW, failure="no camera", failure_code="frames")
    before.append(store.move(given_up.id, ShotState.ABORTED, why))
    before[2] = store.shot(given_up.id)
    results = [store.result(shot.id) for shot in before[:2]]
    lose(store, how)
    if how != "overwritten":
        with pytest.raises(
            StoreError, match=r"missing or empty, and 3 shots of 2026-01-31 to .*rigctl recover"
        ):
            Store(store.path)
    rebuilt = rebuild(store.path, None)
    assert (rebuilt.shots, rebuilt.open, rebuilt.without_key, rebuilt.missing) == (3, [], [], 0)
    again = Store(store.path)
    assert again.shots() == before
    assert [again.result(shot.id) for shot in before[:2]] == results
    for key, shot in zip(("first", "second"), before, strict=False):
        assert again.accept(key, f"body of {key}", refuse) == (shot, True)
        with pytest.raises(KeyReusedError):
            again.accept(key, "another body", refuse)
    assert again.accept("third", "body", refuse) == (before[2], True)
    assert findings(again) == []
    (entry,) = again.edits.entries()
    assert (entry.actor, entry.act, entry.subject) == ("rigctl recover", "recovered", "catalogue")
    again.close()


@sqlite_alone
def test_a_shot_that_had_not_ended_is_closed_as_unknown_by_the_next_start(
    store: Store, fire: Fire, accepted: Fire
) -> None:
    fire("first")
    open_shot = accepted("second").id
    lose(store, "deleted")
    assert rebuild(store.path, None).open == [open_shot]
    again = Store(store.path)
    assert close_open_shots(again, NOW).unknown == (open_shot,)
    ended = again.accept("second", "body", refuse)[0]
    assert (ended.outcome, ended.fired) == (ShotState.UNKNOWN_OUTCOME, Fired.UNKNOWN)
    assert findings(again) == []
    again.close()
    lose(again, "deleted")
    rebuild(store.path, None)
    third = Store(store.path)
    last = third.journal.last()
    assert last is not None
    assert (last.after, last.shot) == ("unknown_outcome", open_shot)
    assert third.accept("second", "body", refuse)[0].outcome is ShotState.UNKNOWN_OUTCOME
    third.close()


@sqlite_alone
def test_a_sweep_whose_key_was_used_does_not_run_again(store: Store, fire: Fire) -> None:
    settings = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=41.0, offset_mm=6.0)
    new = NewSweep((settings, settings), "{}", "{}", "nylon", "anna", NOW)
    sweep = store.sweeps.accept("sweep", "its body", lambda: new)[0].id
    key = str(store.sweeps.take(sweep, 1, NOW).key)
    shot = fire(key, actor=f"sweep {sweep} of anna", note=f"sweep {sweep}, step 1")
    lose(store, "deleted")
    assert rebuild(store.path, None).sweeps == 1
    again = Store(store.path)
    known, there = again.sweeps.accept("sweep", "its body", lambda: new)
    assert (known.id, known.state, there) == (sweep, SweepState.ABORTED, True)
    assert [(str(step.state), step.shot) for step in again.sweeps.steps(sweep)] == [
        ("stored", shot.id),
        ("skipped", None),
    ]
    assert findings(again) == []
    again.close()


@sqlite_alone
def test_imported_campaigns_come_back_between_the_shots(
    store: Store, fire: Fire, tmp_path: Path
) -> None:
    fire("first")
    contents = read_contents(contacts(tmp_path / "tables", 20, 62), silent)
    import_campaign(store, contents, "anna", name="tables", progress=silent)
    fire("second")
    before = store.shots(limit=500)
    lose(store, "deleted")
    with pytest.raises(StoreError, match=r"2 shots .* and 1 imported campaigns"):
        Store(store.path)
    rebuilt = rebuild(store.path, None)
    assert (rebuilt.shots, rebuilt.imports, rebuilt.missing) == (2, 1, 0)
    again = Store(store.path)
    after = again.shots(limit=500)
    assert [(s.number, s.id, s.state, s.settings) for s in after] == [
        (s.number, s.id, s.state, s.settings) for s in before
    ]
    assert again.campaigns.measured("tables") == store_measured(before)
    assert findings(again) == []
    again.close()


def store_measured(before: list[ShotRecord]) -> list[tuple[str, int]]:
    return [(shot.id, shot.results) for shot in before if shot.campaign == "tables"]


@sqlite_alone
def test_shots_of_an_older_store_come_back_without_keys_and_that_is_said(
    store: Store, fire: Fire, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    shot = fire("first")
    path = store.folders.folder(shot.id) / "manifest.json"
    manifest = json.loads(path.read_bytes())
    for later in ("request", "outcome", "audit"):
        del manifest[later]
    path.write_text(json.dumps(manifest))
    lose(store, "deleted")
    config = configured(tmp_path, store.path)
    assert run(["recover", "--config", config]) == 0
    said = capsys.readouterr().out
    assert "1 shots are older than the keys in manifests" in said
    assert "lost with the catalogue: exclusions, notes and tags" in said
    again = Store(store.path)
    known = again.shot(shot.id)
    assert (known.state, known.settings, known.actor) == (shot.state, shot.settings, "not known")
    assert findings(again) == []
    again.close()


def configured(tmp_path: Path, store: Path) -> str:
    config = tmp_path / "rig.toml"
    source = Path("config/simulated.toml").read_text(encoding="utf-8")
    config.write_text(source.replace('folder = "data"', f'folder = "{store}"'))
    return str(config)


@sqlite_alone
def test_a_catalogue_from_before_the_latest_shot_is_refused_and_kept_aside(
    store: Store, fire: Fire
) -> None:
    fire("first")
    old = sqlite3.connect(store.path / "old.db")
    source = sqlite3.connect(store.path / "catalogue.db")
    source.backup(old)
    source.close()
    old.close()
    fire("second")
    lose(store, "deleted")
    (store.path / "old.db").rename(store.path / "catalogue.db")
    with pytest.raises(StoreError, match=r"older than the shots.*found shot number 2, allowed.* 1"):
        Store(store.path)
    rebuilt = rebuild(store.path, None, NOW)
    assert rebuilt.kept == str(store.path / "catalogue.db.lost-20260131T120000")
    assert Path(rebuilt.kept).is_file()
    again = Store(store.path)
    assert again.accept("second", "body of second", refuse)[1]
    again.close()


def test_a_whole_catalogue_is_not_rebuilt_nor_one_that_a_daemon_owns(
    store: Store, fire: Fire
) -> None:
    fire("first")
    with pytest.raises(StoreError, match="another process owns"):
        rebuild(store.path, store.address)
    store.close()
    with pytest.raises(RefusedError, match="whole and knows every shot"):
        rebuild(store.path, store.address)


def test_an_empty_folder_has_nothing_to_rebuild(tmp_path: Path) -> None:
    with pytest.raises(NotFoundError, match="holds no shots"):
        rebuild(tmp_path / "data", None)
    assert run(["recover", "--config", configured(tmp_path, tmp_path / "none")]) == NOT_FOUND
    assert not (tmp_path / "none").exists()


@sqlite_alone
def test_a_manifest_that_cannot_be_read_is_named_and_the_rest_comes_back(
    store: Store, fire: Fire
) -> None:
    broken, whole = fire("first"), fire("second")
    (store.folders.folder(broken.id) / "manifest.json").write_text("{")
    lose(store, "deleted")
    rebuilt = rebuild(store.path, None)
    assert (rebuilt.shots, rebuilt.missing) == (1, 1)
    assert broken.id in rebuilt.unreadable[0]
    again = Store(store.path)
    assert again.shots() == [whole]
    assert any("belongs to no shot" in each for each in findings(again))
    again.close()


def test_an_empty_schema_of_a_server_beside_shots_is_refused_and_filled(
    store: Store, fire: Fire, database: str | None, request: pytest.FixtureRequest
) -> None:
    if database is None:
        pytest.skip("the file is tested above")
    shot = fire("first")
    store.close()
    from sqlalchemy import create_engine

    engine = create_engine(database.replace("postgresql:", "postgresql+psycopg:"))
    with engine.begin() as connection:
        name = connection.exec_driver_sql("SELECT current_schema()").scalar_one()
        connection.exec_driver_sql(f"DROP SCHEMA {name} CASCADE")
        connection.exec_driver_sql(f"CREATE SCHEMA {name}")
    engine.dispose()
    with pytest.raises(StoreError, match="1 shots of 2026-01-31"):
        Store(store.path, database=database)
    assert rebuild(store.path, database).shots == 1
    again = Store(store.path, database=database)
    assert again.accept("first", "body of first", refuse) == (shot, True)
    assert findings(again) == []
    again.close()
