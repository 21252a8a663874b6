"""Pools, disks and catalogues that fail while a campaign is analysed once more."""

from __future__ import annotations

import errno
import os
import signal
import sqlite3
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from rigctl.measuring.analysing import AnalysisFailedError
from rigctl.reanalysis import Pool, pool, reanalyse_campaign
from rigctl.reanalysis.campaign import Broken
from rigctl.store import Store
from tests.unit.reanalysis.stored_campaign import Inline, measured, reanalysed, silent, stored


def test_a_process_that_dies_while_it_learns_the_spheres_is_named_and_nothing_is_added(
    store: Store, shots: list[str]
) -> None:
    with pool(workers=1) as workshop, pytest.MonkeyPatch.context() as patch:
        patch.setattr("rigctl.reanalysis.campaign.taught", die)
        with pytest.raises(AnalysisFailedError, match=r"campaign nylon.*ended with status -9"):
            list(reanalyse_campaign(store, "nylon", "photometric", workshop, silent))
    assert [store.shot(shot).results for shot in shots] == [0, 0, 0]


def test_a_process_that_dies_costs_its_own_shot_and_the_next_shot_has_another(
    store: Store, shots: list[str]
) -> None:
    with pool(workers=1) as workshop, pytest.MonkeyPatch.context() as patch:
        patch.setattr("rigctl.reanalysis.campaign.analysed", die_at_the_second)
        outcomes = list(reanalyse_campaign(store, "nylon", "thesis", workshop, silent))
    first, second, third = (str(outcome.failure) for outcome in outcomes)
    assert "ended with status -9" in second
    assert shots[0] in first
    assert shots[2] in third


def die(*_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def die_at_the_second(folders: Sequence[Path], *_: object) -> list[Broken]:
    """Kill its own process where the shot is the second of the store."""
    store = folders[0].parent
    if sorted(store.iterdir()).index(folders[0]) == 1:
        die()
    return [Broken(f"{folder.name} was here") for folder in folders]


def test_a_result_that_was_damaged_is_not_compared_and_nothing_is_added_beside_it(
    store: Store, shots: list[str], answers: Any
) -> None:
    answers(lambda shot, method: measured(0.7))
    reanalysed(store, "nylon", "thesis")
    store.folders.results(shots[0])[1].write_text("{")
    outcomes = reanalysed(store, "nylon", "thesis")
    assert "result-0001.json" in str(outcomes[0].failure)
    assert [outcome.failure for outcome in outcomes[1:]] == [None, None]


def test_a_full_disk_leaves_shots_as_they_were_and_free_for_the_next_time(
    store: Store, shots: list[str], answers: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    refusal = {"status": "refused", "step": "markers", "reason": "only one marker"}
    answers(lambda shot, method: refusal if shot == shots[1] else measured(0.7))
    reanalysed(store, "nylon", "thesis")
    before = [store.shot(shot) for shot in shots]

    def refuse(source: object, target: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as full:
        full.setattr(os, "link", refuse)
        outcomes = reanalysed(store, "nylon", "thesis")
    assert all("No space left" in str(outcome.failure) for outcome in outcomes)
    assert [outcome.shot for outcome in outcomes] == before
    assert [store.shot(shot) for shot in shots] == before
    reanalysed(store, "nylon", "thesis")
    assert [store.shot(shot).results for shot in shots] == [2, 2, 2]


def test_a_catalogue_that_another_program_locks_costs_the_shots_of_that_time_alone(
    tmp_path: Path, answers: Any
) -> None:
    store = Store(tmp_path / "locked", busy_timeout_s=0.01)
    shots = [stored(store) for _ in range(3)]
    holder = sqlite3.connect(tmp_path / "locked" / "catalogue.db", isolation_level=None)
    holder.execute("BEGIN IMMEDIATE")

    def let_go(text: str, share: float | None) -> None:
        if shots[1] in text:
            holder.execute("ROLLBACK")

    answers(lambda shot, method: measured(0.7))
    pool = Pool(Inline(), lambda: 1)
    first, second, third = reanalyse_campaign(store, "nylon", "thesis", pool, let_go)
    assert "locked" in str(first.failure)
    assert "locked" in str(second.failure)
    assert third.failure is None
    assert [store.shot(shot).state for shot in shots] == ["stored", "stored", "analysed"]
    holder.close()
    store.close()
