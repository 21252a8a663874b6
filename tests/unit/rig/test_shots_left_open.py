"""A shot whose end a locked catalogue could not take has one after the next release."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest
from rig_fakes import Laboratory

from rigctl.errors import StoreError

LOCKED = [
    ("capture", "start", "interrupted", "no", "being prepared; nothing was fired"),
    ("trigger", "fire", "unknown_outcome", "unknown", "being fired; whether it fired is not known"),
    ("capture", "collect", "stored", "yes", None),
]


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Laboratory]:
    laboratory = Laboratory(tmp_path / "data")
    yield laboratory
    laboratory.close()


@pytest.mark.parametrize(
    ("part", "call", "state", "fired", "why"), LOCKED, ids=lambda value: str(value)[:12]
)
def test_a_release_gives_a_shot_whose_end_could_not_be_recorded_its_end(
    lab: Laboratory, part: str, call: str, state: str, fired: str, why: str | None
) -> None:
    token = lab.arm()
    holder = sqlite3.connect(lab.folder / "catalogue.db", isolation_level=None)
    device = getattr(lab, part)
    device.hooks[call] = lambda: holder.execute("BEGIN IMMEDIATE")
    lab.fire(token)
    device.hooks.clear()
    with pytest.raises(StoreError):
        lab.rig.release("anna", "looked at the disk")
    assert lab.state in {"fault", "unknown_outcome"}
    holder.execute("ROLLBACK")
    holder.close()
    lab.rig.release("anna", "looked at the disk")
    assert lab.state == "idle"
    last = lab.store.catalogue.last()
    assert (last.state, last.fired) == (state, fired)
    cause = "the store could not be written while the shot was"
    assert last.failure == (None if why is None else f"{cause} {why}")
    assert lab.to_analyse == ([last.id] if state == "stored" else [])
    assert lab.shoot().state == "stored"
