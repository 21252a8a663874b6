"""One folder a shot: whole or absent, raw frames untouched, results only added."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Never

import numpy as np
import pytest

from rigctl.cameras.frames import FrameSequence
from rigctl.errors import NotFoundError, StoreError
from rigctl.store import Store

SHOT = "20260131-000042"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "data" / "shots" / "20260131" / SHOT


def test_frames_come_back_as_they_went(store: Store, frames: FrameSequence, folder: Path) -> None:
    assert store.folders.write(SHOT, frames, {}) == folder
    back = store.frames(SHOT)
    np.testing.assert_array_equal(back.pixels, frames.pixels)
    np.testing.assert_array_equal(back.times_s, frames.times_s)
    np.testing.assert_array_equal(back.sequence, frames.sequence)
    assert (back.lost, back.source) == (frames.lost, frames.source)
    assert back.pixels.dtype == np.uint8


def test_the_manifest_says_what_a_stranger_needs_to_check_the_frames(
    store: Store, frames: FrameSequence, folder: Path
) -> None:
    store.folders.write(SHOT, frames, {"note": "first"})
    manifest = json.loads((folder / "manifest.json").read_text())
    about = manifest["frames"]
    assert manifest["note"] == "first"
    assert about["sha256"] == hashlib.sha256((folder / "frames.npy").read_bytes()).hexdigest()
    assert (about["shape"], about["dtype"]) == ([5, 16, 24], "uint8")
    assert about["times_s"] == frames.times_s.tolist()
    assert about["lost"] == [103]


def test_files_and_folder_are_forced_to_disk_before_and_after_the_rename(
    store: Store, frames: FrameSequence, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps = []
    sync, rename = os.fsync, type(folder).rename

    def watched_sync(descriptor: int) -> None:
        steps.append(os.path.basename(os.readlink(f"/proc/self/fd/{descriptor}")))
        sync(descriptor)

    def watched_rename(path: Path, target: Path) -> Path:
        steps.append("rename")
        return rename(path, target)

    monkeypatch.setattr(os, "fsync", watched_sync)
    monkeypatch.setattr(type(folder), "rename", watched_rename)
    store.folders.write(SHOT, frames, {})
    partial = f".{SHOT}.partial"
    assert steps[-5:] == ["frames.npy", "manifest.json", partial, "rename", "20260131"]


@pytest.mark.parametrize("point", ["fsync", "rename"])
def test_a_disk_that_refuses_leaves_nothing_behind(
    store: Store, frames: FrameSequence, folder: Path, monkeypatch: pytest.MonkeyPatch, point: str
) -> None:
    def refuse(*_: object) -> Never:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(*((os, "fsync") if point == "fsync" else (type(folder), "rename")), refuse)
    with pytest.raises(StoreError, match="No space left on device"):
        store.folders.write(SHOT, frames, {})
    monkeypatch.undo()
    assert not folder.exists()
    assert list(folder.parent.glob(".*")) == []
    store.folders.write(SHOT, frames, {})
    assert store.folders.is_whole(SHOT)


def test_a_shots_folder_is_never_written_twice(
    store: Store, frames: FrameSequence, folder: Path
) -> None:
    store.folders.write(SHOT, frames, {"note": "first"})
    with pytest.raises(StoreError, match="exists already"):
        store.folders.write(SHOT, frames, {"note": "second"})
    assert store.folders.manifest(SHOT)["note"] == "first"


def test_altered_frames_are_not_handed_out(
    store: Store, frames: FrameSequence, folder: Path
) -> None:
    store.folders.write(SHOT, frames, {})
    path = folder / "frames.npy"
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(content)
    with pytest.raises(StoreError, match="not those that were recorded"):
        store.frames(SHOT)
    assert not store.folders.is_whole(SHOT)


def test_results_are_added_and_the_raw_frames_stay(
    store: Store, frames: FrameSequence, folder: Path
) -> None:
    store.folders.write(SHOT, frames, {})
    before = (folder / "frames.npy").read_bytes(), (folder / "manifest.json").read_bytes()
    assert [store.folders.add_result(SHOT, {"e": n}) for n in range(3)] == [1, 2, 3]
    assert store.result(SHOT) == {"e": 2}
    assert store.result(SHOT, 1) == {"e": 0}
    assert before == ((folder / "frames.npy").read_bytes(), (folder / "manifest.json").read_bytes())
    names = {"frames.npy", "manifest.json", *(f"result-000{n}.json" for n in (1, 2, 3))}
    assert {path.name for path in folder.iterdir()} == names


def test_a_lost_result_does_not_make_room_for_another(
    store: Store, frames: FrameSequence, folder: Path
) -> None:
    store.folders.write(SHOT, frames, {})
    for n in range(3):
        store.folders.add_result(SHOT, {"e": n})
    (folder / "result-0002.json").unlink()
    assert store.folders.add_result(SHOT, {"e": 9}) == 4
    assert store.result(SHOT, 3) == {"e": 2}


def test_a_result_that_is_not_a_number_is_refused(store: Store, frames: FrameSequence) -> None:
    store.folders.write(SHOT, frames, {})
    with pytest.raises(StoreError):
        store.folders.add_result(SHOT, {"e": float("nan")})
    with pytest.raises(NotFoundError):
        store.result(SHOT)


def test_what_is_not_there_is_not_found(store: Store, frames: FrameSequence) -> None:
    for ask in (store.frames, store.result, store.folders.manifest):
        with pytest.raises(NotFoundError):
            ask(SHOT)
    with pytest.raises(NotFoundError):
        store.folders.add_result(SHOT, {})
    store.folders.write(SHOT, frames, {})
    with pytest.raises(NotFoundError):
        store.result(SHOT, 7)


@pytest.mark.parametrize("name", ["", "..", "../20260131-000042", "20260131-000042/..", "a-b"])
def test_no_name_leads_out_of_the_store(store: Store, frames: FrameSequence, name: str) -> None:
    with pytest.raises(NotFoundError):
        store.folders.write(name, frames, {})
    with pytest.raises(NotFoundError):
        store.frames(name)


def test_leftovers_of_a_killed_writer_are_removed_and_nothing_else(
    store: Store, frames: FrameSequence, folder: Path
) -> None:
    store.folders.write(SHOT, frames, {})
    leftover = folder.with_name(".20260131-000043.partial")
    leftover.mkdir()
    (leftover / "frames.npy").write_bytes(b"half")
    (folder / ".result.partial").write_bytes(b"{")
    assert store.folders.remove_partial() == 2
    assert not leftover.exists()
    assert store.folders.is_whole(SHOT)
    assert {path.name for path in folder.iterdir()} == {"frames.npy", "manifest.json"}
