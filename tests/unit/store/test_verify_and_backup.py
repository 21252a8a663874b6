"""Is everything as it was stored, and a copy that can be trusted as much."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import stat
import threading
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from rigctl.access.keyring import Keyring
from rigctl.access.named_keys import KeyFile, NamedKey, hashed
from rigctl.access.scopes import Scope
from rigctl.cameras.frames import FrameSequence
from rigctl.errors import NotFoundError, StoreError
from rigctl.settings import ShotSettings
from rigctl.store import Change, NewShot, NewSweep, ShotState, Store, reading
from rigctl.store.integrity.copying import Backup, back_up
from rigctl.store.integrity.ledger import begin
from rigctl.store.integrity.seal import read_seal, read_secret
from rigctl.store.integrity.verifying import Verified, verify_store
from rigctl.store.orders import Orders
from tests.unit.store.conftest import perform, without_guard

Fire = Callable[..., str]


def silent(_text: str, _share: float | None) -> None:
    """Say nothing."""


@pytest.fixture
def fire(store: Store, new_shot: Callable[..., NewShot], frames: FrameSequence) -> Fire:
    """Carry a shot to `analysed`, with frames and one result."""

    def fired(key: str = "key", **changes: object) -> str:
        shot = store.accept(key, "body", lambda: new_shot(**changes))[0].id
        store.move(shot, ShotState.FIRING)
        store.move(shot, ShotState.CAPTURING)
        store.folders.write(shot, frames, {"shot": shot})
        store.move(shot, ShotState.STORED, Change(frames=len(frames.pixels)))
        store.move(shot, ShotState.ANALYSING)
        number = store.folders.add_result(shot, {"e": 0.7})
        store.move(shot, ShotState.ANALYSED, Change(results=number))
        return shot

    return fired


def verified(store: Store, campaign: str | None = None) -> Verified:
    with reading(store.path, store.address) as reader:
        return verify_store(reader, silent, campaign)


def copied(store: Store, target: Path) -> Backup:
    target.mkdir()
    with reading(store.path, store.address) as reader:
        return back_up(reader, target, silent)


def test_a_store_that_nobody_touched_has_no_faults(store: Store, fire: Fire) -> None:
    first, _ = fire("1"), fire("2", campaign="brass")
    store.exclude(first, "why", "anna")
    # Two shots with a key and a result each, and one change.
    assert verified(store) == Verified(shots=2, files=6, entries=1, faults=(), rows=7)
    assert verified(store, "brass").shots == 1
    with pytest.raises(NotFoundError, match="no such campaign"):
        verified(store, "steel")


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def forge(folder: Path) -> None:
    """Change frames and manifest so that they agree with each other."""
    pixels = np.zeros((5, 16, 24), dtype=np.uint8)
    np.save(folder / "frames.npy", pixels)
    manifest = json.loads((folder / "manifest.json").read_bytes())
    digest = hashlib.sha256((folder / "frames.npy").read_bytes()).hexdigest()
    manifest["frames"]["sha256"] = digest
    (folder / "manifest.json").write_text(json.dumps(manifest))


@pytest.mark.parametrize(
    ("spoil", "part", "words"),
    [
        (lambda f: flip(f / "frames.npy"), "frames.npy", "are not the frames recorded"),
        (lambda f: flip(f / "manifest.json"), "manifest.json", "is not the one that was stored"),
        (forge, "manifest.json", "is not the one that was stored"),
        (lambda f: (f / "frames.npy").unlink(), "", "cannot be read"),
        (lambda f: (f / "manifest.json").unlink(), "manifest.json", "is missing"),
        (lambda f: (f / "result-0001.json").unlink(), "result-0001.json", "is missing"),
        (
            lambda f: (f / "result-0001.json").write_text('{"e": 0.8}'),
            "result-0001.json",
            "is not the result that was stored",
        ),
        (lambda f: (f / "result-0001.json").write_text("{"), "result-0001.json", "cannot be read"),
    ],
)
def test_whatever_was_altered_or_lost_is_named(
    store: Store, fire: Fire, spoil: Callable[[Path], object], part: str, words: str
) -> None:
    fire("1")
    folder = store.folders.folder(fire("2"))
    spoil(folder)
    (fault,) = verified(store).faults
    assert fault.part == str(folder / part if part else folder)
    assert words in fault.what


def as_before_digests(store: Store) -> None:
    """Leave the catalogue as one is that was brought to the present form."""
    for table in ("results", "ledger"):
        without_guard(store, table)
        perform(store, f"DELETE FROM {table}")
    with store._database.writing() as connection:
        begin(connection, read_seal(store.path))


def test_every_result_is_compared_with_its_own_digest(store: Store, fire: Fire) -> None:
    shot = fire()
    store.move(shot, ShotState.ANALYSING)
    number = store.folders.add_result(shot, {"e": 0.8})
    record = store.move(shot, ShotState.ANALYSED, Change(results=number))
    contents = [path.read_bytes() for path in store.folders.results(shot).values()]
    wanted = {k: hashlib.sha256(text).hexdigest() for k, text in enumerate(contents, start=1)}
    assert store.catalogue.results(record) == wanted
    assert len(set(wanted.values())) == 2
    folder = store.folders.folder(shot)
    (folder / "result-0001.json").write_bytes(contents[1])
    (fault,) = verified(store).faults
    assert fault.part == str(folder / "result-0001.json")


def test_results_of_an_older_store_are_read_and_said_to_be_unchecked(
    store: Store, fire: Fire
) -> None:
    old = fire("old")
    as_before_digests(store)
    fire("young")
    folder = store.folders.folder(old)
    (folder / "result-0001.json").write_text('{"e": 0.8}')
    assert verified(store) == Verified(2, files=6, entries=0, faults=(), unchecked=1, rows=5)
    (folder / "result-0001.json").write_text("{")
    assert "cannot be read" in verified(store).faults[0].what
    (folder / "result-0001.json").unlink()
    assert [fault.what for fault in verified(store).faults] == ["holds 0 results of 1"]


def test_the_digest_of_a_result_is_kept_from_the_first_time(store: Store, fire: Fire) -> None:
    shot = fire()
    (store.folders.folder(shot) / "result-0001.json").write_text('{"e": 0.8}')
    store.move(shot, ShotState.ANALYSING)
    store.move(shot, ShotState.ANALYSED, Change(results=1))
    assert "is not the result that was stored" in verified(store).faults[0].what


def test_the_digest_of_a_result_cannot_be_changed(store: Store, fire: Fire) -> None:
    fire()
    for statement in ("UPDATE results SET digest = 'other'", "DELETE FROM results"):
        with pytest.raises(StoreError, match="append-only"):
            perform(store, statement)


def test_a_folder_that_belongs_to_nothing_is_named(store: Store, fire: Fire) -> None:
    folder = store.folders.folder(fire())
    (folder.parent / "20260131-000009").mkdir()
    (folder.parents[1] / "i0004").mkdir()
    assert [fault.what for fault in verified(store).faults] == [
        "belongs to no shot of the catalogue",
        "belongs to no campaign: an import was cut short",
    ]


def test_an_altered_audit_is_named(store: Store, fire: Fire) -> None:
    store.exclude(fire(), "why", "anna")
    without_guard(store, "edits")
    perform(store, "UPDATE edits SET after = 'other'")
    chain, row = verified(store).faults
    assert "altered (found edit 1)" in chain.what
    assert (row.part, row.what.partition(":")[0]) == ("edits [1]", "is not as it was last written")


def test_a_backup_is_a_store_of_its_own(store: Store, fire: Fire, tmp_path: Path) -> None:
    first, second = fire("1"), fire("2")
    store.exclude(second, "why", "anna")
    store.annotate_campaign("nylon", "a wet day", "anna")
    store.tag_campaign("nylon", ["wet"], "anna")
    store.fits.add("nylon", "base", {"campaign": "nylon"})
    (store.path / "estop.json").write_text("{}")
    assert copied(store, tmp_path / "copy") == Backup(shots=2, files=7)
    copy = Store(tmp_path / "copy")
    assert [shot.id for shot in copy.shots()] == [first, second]
    assert copy.shot(second) == store.shot(second)
    np.testing.assert_array_equal(copy.frames(first).pixels, store.frames(first).pixels)
    assert copy.result(first) == {"e": 0.7}
    assert copy.campaigns.one("nylon") == store.campaigns.one("nylon")
    assert copy.campaigns.one("nylon").tags == ("wet",)
    assert copy.fits.fit("nylon", "base") == (1, {"campaign": "nylon"})
    assert (copy.path / "estop.json").read_text() == "{}"
    assert verified(copy) == verified(store)
    copy.close()


def test_the_keys_of_a_store_open_its_backup_and_what_was_ordered_is_known_there(
    store: Store, fire: Fire, new_shot: Callable[..., NewShot], tmp_path: Path
) -> None:
    fire()
    given, gone = "key-of-the-thread-2026", "key-that-was-revoked-2026"
    keys, secret, at = KeyFile(store.path), read_secret(store.path), datetime.now(UTC)
    assert secret is not None
    for name, key in (("anna", given), ("berta", gone)):
        keys.add(NamedKey(name, (Scope.OPERATE,), hashed(key, secret), at.isoformat()))
    keys.revoke("berta", at)
    sweep = store.sweeps.accept("sweep", "body", new_sweep)[0].id
    open_shot = store.accept("open", "body", new_shot)[0].id
    before = os.umask(0o022)
    try:
        copied(store, tmp_path / "copy")
    finally:
        os.umask(before)
    elsewhere = tmp_path / "elsewhere"
    shutil.move(tmp_path / "copy", elsewhere)
    opened = Keyring("the-daemon's-own-key-2026", lambda: elsewhere)
    holder, _ = opened.holder(given)
    assert holder is not None
    assert (holder.name, holder.scopes) == ("anna", {Scope.OPERATE})
    assert opened.holder(gone)[0] is None
    with reading(elsewhere) as copy:
        assert verify_store(copy, silent).faults == ()
        assert Orders(copy.folders).read(open_shot)["shot"] == open_shot
    kept = json.loads((elsewhere / "sweeps" / f"{sweep}.json").read_bytes())
    assert (kept["id"], len(kept["steps"])) == (sweep, 2)
    paths = (elsewhere, *elsewhere.rglob("*"))
    assert {stat.S_IMODE(path.stat().st_mode) for path in paths} == {0o600, 0o700}


def new_sweep() -> NewSweep:
    steps = tuple(
        ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=x) for x in (1, 2)
    )
    return NewSweep(steps, "{}", "{}", "nylon", "anna", datetime.now(UTC))


def test_a_backup_taken_while_shots_are_fired_is_whole(
    store: Store, fire: Fire, tmp_path: Path
) -> None:
    fire("first")
    ended, going = threading.Event(), threading.Event()

    def keep_firing() -> None:
        number = 0
        while not ended.is_set():
            fire(f"key {number}")
            number += 1
            going.set()

    thread = threading.Thread(target=keep_firing)
    thread.start()
    try:
        assert going.wait(120)
        for k in range(3):
            assert copied(store, tmp_path / f"copy {k}").shots > 0
    finally:
        ended.set()
        thread.join(120)
    for k in range(3):
        with reading(tmp_path / f"copy {k}") as copy:
            assert verify_store(copy, silent).faults == ()
            assert copy.catalogue.count() <= len(store.shots(limit=10_000))
    assert verified(store).faults == ()


def test_a_store_that_is_not_whole_is_not_backed_up_as_if_it_were(
    store: Store, fire: Fire, tmp_path: Path
) -> None:
    flip(store.folders.folder(fire()) / "frames.npy")
    with pytest.raises(StoreError, match=r"not what was stored.*frames\.npy"):
        copied(store, tmp_path / "copy")


def test_the_digest_of_a_manifest_is_kept_from_the_first_time(store: Store, fire: Fire) -> None:
    shot = fire()
    first = store.shot(shot).manifest
    assert first == store.folders.digest(shot)
    flip(store.folders.folder(shot) / "manifest.json")
    store.move(shot, ShotState.ANALYSING)
    store.move(shot, ShotState.STORED)
    assert store.shot(shot).manifest == first
