"""Nothing in the catalogue can be changed behind the program's back without a finding.

The oracle is the damage itself: whatever was changed must be found, and once it is undone nothing.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

import pytest

from rigctl.cameras.frames import FrameSequence
from rigctl.cli import BAD_INPUT, REFUSED, run
from rigctl.errors import StoreError
from rigctl.settings import ShotSettings
from rigctl.store import Change, Fired, NewShot, NewSweep, ShotState, Store, SweepState, reading
from rigctl.store.campaign_remarks import Remarks
from rigctl.store.imports import ImportedShot
from rigctl.store.integrity.anchors import add_anchor, read_anchors
from rigctl.store.integrity.ledger import begin
from rigctl.store.integrity.seal import FILE_NAME, new_seal
from rigctl.store.integrity.verifying import verify_store
from rigctl.store.sql.schema import metadata
from tests.unit.store.conftest import perform, sqlite_alone, without_guard

NOW = datetime(2026, 1, 31, 12, 0, tzinfo=UTC)
SETTINGS = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=41.0, offset_mm=6.0)
APPEND_ONLY = ("transitions", "edits", "results", "ledger")
COLUMNS = [
    (table.name, column.name)
    for table in metadata.sorted_tables
    if table.name != "probe"
    for column in table.columns
]
"""All but the row that proves that commits come through."""


def faults(store: Store) -> list[str]:
    with reading(store.path, store.address) as reader:
        found = verify_store(reader, lambda _text, _share: None).faults
    return [f"{fault.part}: {fault.what}" for fault in found]


def fired(store: Store, shot: str, frames: FrameSequence) -> None:
    store.move(shot, ShotState.FIRING, Change(fired=Fired.UNKNOWN))
    store.move(shot, ShotState.CAPTURING, Change(fired=Fired.YES, fired_at=NOW))
    store.keep_frames(store.shot(shot), frames, {"program": "rigctl"})
    kept = Change(frames=len(frames.pixels), lost=len(frames.lost), ended_at=NOW)
    store.move(shot, ShotState.STORED, kept)
    store.move(shot, ShotState.ANALYSING)
    number = store.folders.add_result(shot, {"e": 0.7})
    store.move(shot, ShotState.ANALYSED, Change(results=number))


@pytest.fixture
def full(
    store: Store, new_shot: Callable[..., NewShot], frames: FrameSequence, tmp_path: Path
) -> Store:
    """A store with at least one row in every table, and something in every column."""
    first = store.accept("key 1", "body 1", lambda: new_shot(note="dry"))[0]
    fired(store, first.id, frames)
    given_up = store.accept("key 2", "body 2", new_shot)[0]
    why = Change(fired=Fired.NO, ended_at=NOW, failure="no camera", failure_code="frames")
    store.move(given_up.id, ShotState.ABORTED, why)
    store.exclude(first.id, "grease", "anna")
    store.tag(first.id, ["wet", "cold"], "anna")
    store.annotate_campaign("nylon", "a note", "anna")
    store.tag_campaign("nylon", ["wet"], "anna")
    for shot in (None, first.id):
        store.journal.append(
            at=NOW, before="idle", after="idle", actor="anna", reason="why", shot=shot
        )
    sweep = NewSweep((SETTINGS, SETTINGS), "{}", "{}", "nylon", "anna", NOW)
    name = store.sweeps.accept("key 3", "body 3", lambda: sweep)[0].id
    step = store.sweeps.take(name, 1, NOW)
    store.accept(str(step.key), "body 4", new_shot)
    store.sweeps.move(name, SweepState.ABORTED, "enough", NOW)
    with store.imports.staged("steel") as stage:
        home = stage.path / stage.shot(7)
        home.mkdir()
        (home / "manifest.json").write_text('{"number": 7, "campaign": "steel", "frames": null}')
        (home / "result-0001.json").write_text("{}")
        (stage.path / "import.json").write_text('{"files": {}}')
        shot = ImportedShot(7, SETTINGS, NOW, ShotState.ANALYSED, None, tags=("dry",))
        store.imports.publish(stage, "steel", [shot], "anna", Remarks("imported", ("dry",)))
    return store


@pytest.fixture
def behind(full: Store) -> Iterator[sqlite3.Connection]:
    """The catalogue as another program sees it that keeps to no rule."""
    for table in APPEND_ONLY:
        without_guard(full, table)
    with closing(sqlite3.connect(full.path / "catalogue.db", isolation_level=None)) as file:
        file.execute("PRAGMA ignore_check_constraints = ON")
        yield file


def other(value: object) -> object:
    """Return a value of the same kind that differs in one bit, or something in the place of none.

    A column of a strict table takes no other kind.
    """
    if value is None:
        return None
    if isinstance(value, str):
        return value[:-1] + chr(ord(value[-1]) ^ 1) if value else "x"
    return int(str(value)) ^ 1


@sqlite_alone
@pytest.mark.parametrize(("most", "flips"), [(1, 60), pytest.param(3, 100, marks=pytest.mark.long)])
def test_one_bit_in_any_column_is_found(
    full: Store, behind: sqlite3.Connection, most: int, flips: int
) -> None:
    assert faults(full) == []
    flipped, unseen = 0, list[str]()
    for table, column in COLUMNS:
        for rowid, value in behind.execute(
            f"SELECT rowid, {column} FROM {table} LIMIT {most}"
        ).fetchall():
            if (changed := other(value)) is None:
                continue
            change = f"UPDATE {table} SET {column} = ? WHERE rowid = ?"
            try:
                behind.execute(change, (changed, rowid))
            except sqlite3.IntegrityError:
                continue  # Another row has that name already.
            now = rowid if column != "number" or table in NAMED_BY_TEXT else changed
            if not faults(full):
                unseen.append(f"{table}.{column}: {value!r} became {changed!r}")
            behind.execute(change, (value, now))
            flipped += 1
    assert unseen == []
    assert flipped > flips
    assert faults(full) == []


NAMED_BY_TEXT = ("results", "sweep_steps")
"""Tables in which the column `number` is not the row's own identifier."""


@sqlite_alone
def test_a_word_put_into_an_empty_column_is_found(full: Store, behind: sqlite3.Connection) -> None:
    unseen = []
    for table, column in COLUMNS:
        rows = behind.execute(f"SELECT rowid FROM {table} WHERE {column} IS NULL").fetchall()
        change = f"UPDATE {table} SET {column} = ? WHERE rowid = ?"
        for (rowid,) in rows:
            for word in ("x", 1):
                try:
                    behind.execute(change, (word, rowid))
                except sqlite3.IntegrityError:
                    continue  # Not the column's kind.
                if not faults(full):
                    unseen.append(f"{table}.{column}")
                behind.execute(change, (None, rowid))
    assert unseen == []
    assert faults(full) == []


@sqlite_alone
@pytest.mark.parametrize("table", [t.name for t in metadata.sorted_tables if t.name != "probe"])
def test_a_row_that_was_taken_away_is_found(
    full: Store, behind: sqlite3.Connection, table: str
) -> None:
    names = [column.name for column in metadata.tables[table].columns]
    for row in behind.execute(f"SELECT rowid, * FROM {table}").fetchall():
        behind.execute(f"DELETE FROM {table} WHERE rowid = ?", row[:1])
        assert faults(full), f"a row of {table}: {row}"
        places = ", ".join("?" * len(names))
        behind.execute(f"INSERT INTO {table} ({', '.join(names)}) VALUES ({places})", row[1:])
    assert faults(full) == []


def test_on_a_server_too_a_changed_row_is_found_and_the_column_is_named(full: Store) -> None:
    for change, words in (
        ("actor = 'ben'", "request.actor is 'ben' in the catalogue and 'anna' in the manifest"),
        ("campaign = 'brass'", "campaign is 'brass' in the catalogue and 'nylon' in the manifest"),
        ("fired = 'no'", "fired is 'no' in the catalogue and 'yes' in the manifest"),
        ("simulated = 0", "simulated is False in the catalogue and True in the manifest"),
        ("outcome = 'aborted'", "state is 'aborted' in the catalogue and 'stored' in the manifest"),
    ):
        before = full.shots()[0]
        perform(full, f"UPDATE shots SET {change} WHERE number = 1")
        found = "\n".join(faults(full))
        assert words in found, found
        assert "shots [1]: is not as it was last written" in found
        column = change.partition(" ")[0]
        value = getattr(before, column)
        written = int(value) if isinstance(value, bool) else f"'{value}'"
        perform(full, f"UPDATE shots SET {column} = {written} WHERE number = 1")
    assert faults(full) == []


def test_an_idempotency_key_that_was_taken_away_is_found(full: Store) -> None:
    perform(full, "DELETE FROM idempotency_keys WHERE key = 'key 1'")
    found = "\n".join(faults(full))
    assert "request.key is None in the catalogue and 'key 1' in the manifest" in found
    assert 'idempotency_keys ["key 1"]: is missing' in found


@sqlite_alone
@pytest.mark.parametrize(
    "change",
    [
        "state = 'nonsense'",
        "id = '../../etc'",
        "settings = '{'",
        "accepted_at = 'yesterday'",
        "actor = CAST(x'ff' AS TEXT)",
    ],
)
def test_a_row_that_makes_no_sense_is_a_finding_and_no_traceback(
    full: Store, behind: sqlite3.Connection, change: str
) -> None:
    behind.execute(f"UPDATE shots SET {change} WHERE number = 2")
    assert any(part.startswith("shots [2]: its ") for part in faults(full)), faults(full)


@sqlite_alone
def test_a_page_of_the_file_that_is_damaged_is_a_finding(
    full: Store, behind: sqlite3.Connection
) -> None:
    behind.execute("PRAGMA writable_schema = ON")
    behind.execute("DELETE FROM sqlite_master WHERE name = 'ix_shots_state'")
    assert any("catalogue.db: " in part for part in faults(full))


def cut(store: Store, entries: int) -> None:
    """Take the last entries of the ledger away, and the rows with them that they tell of."""
    without_guard(store, "ledger")
    last = "SELECT max(number) FROM ledger"
    perform(store, f"DELETE FROM ledger WHERE number > ({last}) - {entries}")


def test_a_ledger_cut_before_a_shot_is_found_by_the_shots_manifest(
    store: Store, new_shot: Callable[..., NewShot], frames: FrameSequence
) -> None:
    before = store._database.head()
    shot = store.accept("key", "body", new_shot)[0].id
    fired(store, shot, frames)
    without_guard(store, "results")
    for table in ("results", "idempotency_keys", "shots"):
        perform(store, f"DELETE FROM {table}")
    cut(store, store._database.head().entry - before.entry)
    # Every row agrees with the ledger again: only the shot itself tells.
    assert [part for part in faults(store) if "belongs to no shot" in part]
    store.close()
    with pytest.raises(StoreError, match="older than the shots beside it"):
        Store(store.path, database=store.address)


def test_a_tail_that_was_cut_is_found_by_an_anchor_kept_elsewhere(
    store: Store, new_shot: Callable[..., NewShot], tmp_path: Path
) -> None:
    shot = store.accept("key", "body", new_shot)[0].id
    without = store._database.head().entry
    store.exclude(shot, "grease", "anna")
    elsewhere = tmp_path / "anchors"
    add_anchor(elsewhere, store._database.head())
    kept = [(str(elsewhere), each) for each in read_anchors(elsewhere)]

    def found() -> list[str]:
        with reading(store.path, store.address) as reader:
            verified = verify_store(reader, lambda _text, _share: None, None, kept)
        return [f"{fault.part}: {fault.what}" for fault in verified.faults]

    assert found() == []
    without_guard(store, "edits")
    perform(store, "DELETE FROM edits")
    perform(store, "UPDATE shots SET excluded = NULL")
    cut(store, store._database.head().entry - without)
    assert faults(store) == []
    (fault,) = found()
    assert f"ends at entry {without}" in fault
    assert str(elsewhere) in fault


def test_a_ledger_written_anew_with_another_key_is_found_by_the_manifests(
    full: Store,
) -> None:
    without_guard(full, "ledger")
    perform(full, "DELETE FROM ledger")
    (full.path / FILE_NAME).unlink()
    with full._database.writing() as connection:
        begin(connection, new_seal(full.path))
    assert any("is not the one that the manifest of shot" in part for part in faults(full))


def test_the_key_of_the_audit_is_its_owners_alone_and_its_loss_is_said(full: Store) -> None:
    path = full.path / FILE_NAME
    assert path.stat().st_mode & 0o777 == 0o600
    full.close()
    key = path.read_text()
    path.write_text(f"{'0' * 64}\n")
    with pytest.raises(StoreError, match="not closed by the key of this store"):
        Store(full.path, database=full.address)
    path.unlink()
    assert any("audit.key: is missing" in part for part in faults(full))
    with pytest.raises(StoreError, match=r"key of the audit is missing.*rigctl recover"):
        Store(full.path, database=full.address)
    path.write_text(key)
    Store(full.path, database=full.address).close()


def test_a_result_that_the_catalogue_does_not_know_is_found(full: Store) -> None:
    shot = full.shots()[0].id
    full.folders.add_result(shot, {"e": 0.9})
    assert any("is a result that the catalogue does not know" in part for part in faults(full))


def test_verify_keeps_heads_of_the_audit_where_it_is_told_to(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "rig.toml"
    source = Path("config/simulated.toml").read_text(encoding="utf-8")
    config.write_text(source.replace('folder = "data"', f'folder = "{tmp_path / "data"}"'))
    Store(tmp_path / "data").close()
    elsewhere = tmp_path / "anchors"
    verify = ["verify", "--config", str(config), "--anchor", str(elsewhere)]
    assert [run(verify), run(verify)] == [0, 0]
    first, second = elsewhere.read_text().splitlines()
    assert first == second
    elsewhere.write_text(first.replace('"entry": 1', '"entry": 9'))
    assert run(verify) == REFUSED
    assert "ends at entry 1, before entry 9" in capsys.readouterr().out
    elsewhere.write_text("nonsense")
    assert run(verify) == BAD_INPUT
