"""What becomes of a shot's result while the disk is full: said at once, tried again, never lost.

The kernel itself refuses to let any file of this process grow beyond a size.
"""

from __future__ import annotations

import resource
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from rig_fakes import Laboratory, until

from rigctl.errors import StoreError
from rigctl.measuring.analysing import Analyser
from rigctl.measuring.result_keeping import WAITS_S, Keeper
from rigctl.store import ShotRecord

LARGE = {"status": "measured", "text": "x" * 1_000_000}
ROOM = 500_000
"""Enough for the catalogue, too little for a large result."""


@contextmanager
def files_at_most(size: int) -> Iterator[None]:
    """Let no file of this process grow beyond a size."""
    usual = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, usual[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)


def free() -> None:
    """Make room before the end of `files_at_most`."""
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))


class Rest:
    """Notes how long it was asked to wait; acts at the wait of a number."""

    def __init__(self, at: int = 0, act: object = None) -> None:
        self.waited: list[float] = []
        self._at, self._act = at, act

    def __call__(self, wait_s: float) -> bool:
        self.waited.append(wait_s)
        if len(self.waited) == self._at:
            self._act()
        return False


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Laboratory]:
    laboratory = Laboratory(tmp_path / "data")
    yield laboratory
    laboratory.close()


@pytest.fixture
def heard(lab: Laboratory) -> list[ShotRecord]:
    """Return what listeners of the store are told."""
    told: list[ShotRecord] = []
    lab.store.listeners.add(told.append)
    return told


def begun(lab: Laboratory, keeper: Keeper, shot: str) -> ShotRecord:
    before = keeper.begin(shot)
    assert before is not None
    return before


def test_a_result_waits_for_room_on_the_disk_and_says_so_meanwhile(
    lab: Laboratory, heard: list[ShotRecord]
) -> None:
    shot, rest = lab.shoot().id, Rest(at=3, act=free)
    keeper = Keeper(lab.store, rest)
    with files_at_most(ROOM):
        keeper.keep(begun(lab, keeper, shot), LARGE)
    stored = lab.store.shot(shot)
    assert (stored.state, stored.results, stored.failure) == ("analysed", 1, None)
    assert lab.store.result(shot) == LARGE
    assert rest.waited == list(WAITS_S[:3])
    said = [record.failure for record in heard if record.failure]
    assert len(said) == 3
    assert "not on disk yet: File too large; free disk space; it is tried again in 1 s" in said[0]


def test_a_disk_that_stays_full_refuses_the_shot_with_the_reason_and_leaves_nothing_behind(
    lab: Laboratory,
) -> None:
    shot, rest = lab.shoot().id, Rest()
    keeper = Keeper(lab.store, rest)
    before = {path.name for path in lab.store.folders.folder(shot).iterdir()}
    with files_at_most(ROOM):
        keeper.keep(begun(lab, keeper, shot), LARGE)
    stored = lab.store.shot(shot)
    assert (stored.state, stored.failure_code, stored.results) == ("refused", "store", 0)
    assert "could not be stored: File too large; free disk space, then have it" in stored.failure
    assert rest.waited == list(WAITS_S)
    assert {path.name for path in lab.store.folders.folder(shot).iterdir()} == before
    keeper.keep(begun(lab, keeper, shot), LARGE)
    assert lab.store.shot(shot).state == "analysed"
    assert lab.store.shot(shot).failure is None


def test_a_shot_that_was_measured_before_stays_measured(lab: Laboratory) -> None:
    shot, keeper = lab.shoot().id, Keeper(lab.store, Rest())
    keeper.keep(begun(lab, keeper, shot), {"status": "measured"})
    with files_at_most(ROOM):
        keeper.keep(begun(lab, keeper, shot), LARGE)
    stored = lab.store.shot(shot)
    assert (stored.state, stored.results) == ("analysed", 1)
    assert "could not be stored" in stored.failure
    assert lab.store.result(shot) == {"status": "measured"}


def test_an_end_that_the_catalogue_does_not_take_either_is_written_once_there_is_room(
    lab: Laboratory,
) -> None:
    shot, keeper = lab.shoot().id, Keeper(lab.store, Rest())
    before = begun(lab, keeper, shot)
    with files_at_most(0):
        keeper.keep(before, LARGE)
    assert lab.store.shot(shot).state == "analysing"
    assert keeper.idle_s is not None
    keeper.try_again()
    assert lab.store.shot(shot).state == "refused"
    assert keeper.idle_s is None


def test_an_end_that_was_never_written_leaves_the_shot_to_the_next_start(lab: Laboratory) -> None:
    shot, keeper = lab.shoot().id, Keeper(lab.store, Rest())
    before = begun(lab, keeper, shot)
    with files_at_most(0):
        keeper.keep(before, LARGE)
    lab.to_analyse.clear()
    lab.restart()
    assert lab.to_analyse == [shot]
    assert lab.store.frames(shot).pixels.shape[0] == 4


def test_an_analysis_that_the_catalogue_does_not_let_begin_changes_nothing(
    lab: Laboratory, heard: list[ShotRecord]
) -> None:
    shot = lab.shoot().id
    heard.clear()
    with files_at_most(0):
        assert Keeper(lab.store, Rest()).begin(shot) is None
    assert lab.store.shot(shot).state == "stored"
    assert len(heard) == len(WAITS_S)


def test_a_shot_is_not_analysed_twice_at_a_time(lab: Laboratory) -> None:
    shot, keeper, other = lab.shoot().id, Keeper(lab.store, Rest()), Keeper(lab.store, Rest())
    begun(lab, keeper, shot)
    with pytest.raises(StoreError, match="being analysed already"):
        other.begin(shot)


def test_an_analyser_takes_a_shot_up_again_that_it_could_not_begin(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    shot, waits = lab.shoot().id, list[float]()

    def rest(_ended: threading.Event, wait_s: float) -> bool:
        waits.append(wait_s)
        if len(waits) > len(WAITS_S):
            free()
        return False

    with files_at_most(0):
        analyser = Analyser(
            lab.store,
            workers=1,
            method="thesis",
            timeout_s=60.0,
            function="stand_in_analysis:measured",
            rest=rest,
        )
        analyser.submit(shot)
        until(lambda: len(waits) > len(WAITS_S))
    until(lambda: lab.store.shot(shot).state == "analysed")
    analyser.close()
    assert lab.store.result(shot)["status"] == "measured"
