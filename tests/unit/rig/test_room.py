"""A shot fires only while the room that its frames take on the disk is held."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from rig_fakes import Laboratory, stack

from rigctl.store.durable import BESIDE_FRAMES


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Laboratory]:
    laboratory = Laboratory(tmp_path / "data")
    yield laboratory
    laboratory.close()


def held(lab: Laboratory) -> list[os.stat_result]:
    return [path.stat() for path in (lab.folder / "shots").glob(".room*")]


def frames_bytes(lab: Laboratory) -> int:
    camera = lab.configuration.camera
    frames = camera.frames_before_mark + camera.frames_after_mark
    return camera.rows * camera.columns * frames


def test_room_for_all_frames_is_held_when_the_fire_command_leaves(lab: Laboratory) -> None:
    seen: list[os.stat_result] = []
    lab.trigger.hooks["fire"] = lambda: seen.extend(held(lab))
    lab.shoot()
    assert seen[0].st_size >= frames_bytes(lab)
    # Blocks of 512 bytes that the file system has given, as opposed to a size with holes.
    assert 512 * seen[0].st_blocks >= frames_bytes(lab)


def test_the_room_becomes_the_file_of_the_frames(lab: Laboratory) -> None:
    seen: list[os.stat_result] = []
    lab.capture.hooks["collect"] = lambda: seen.extend(held(lab))
    shot = lab.shoot()
    kept = lab.store.folders.folder(shot.id) / "frames.npy"
    assert kept.stat().st_ino == seen[0].st_ino
    np.testing.assert_array_equal(np.load(kept), stack().pixels)
    assert kept.stat().st_size < stack().pixels.nbytes + 4096
    assert held(lab) == []


def test_without_that_room_nothing_fires_and_the_interlock_says_how_much_is_missing(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    token = lab.arm()

    def full(_descriptor: int, _offset: int, _size: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "posix_fallocate", full)
    shot = lab.fire(token)
    assert (shot.state, shot.fired) == ("aborted", "no")
    assert lab.trigger.fired == []
    assert shot.failure is not None
    assert "room: " in shot.failure
    assert "bytes free" in shot.failure
    assert f"needed at least {frames_bytes(lab) + BESIDE_FRAMES} bytes" in shot.failure
    assert held(lab) == []
    monkeypatch.undo()
    assert lab.shoot().state == "stored"


def test_a_shot_that_fails_gives_its_room_back(lab: Laboratory) -> None:
    token = lab.arm()
    lab.capture.errors["collect"] = RuntimeError("no frames")
    assert lab.fire(token).state == "aborted"
    assert held(lab) == []


def test_a_restart_frees_what_a_killed_daemon_held(lab: Laboratory) -> None:
    lab.store.folders.room.hold(1000)
    assert lab.store.folders.remove_partial() == 1
    assert held(lab) == []
