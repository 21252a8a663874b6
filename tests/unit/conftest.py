"""What tests of several rooms start from."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rigctl.store import Store

WAITS = {
    "rigctl.rig.stopping.estop": ("LINE_WAIT_S", "REST_WAIT_S", "WITNESS_WAIT_S"),
    "rigctl.rig.standing": ("NOTE_WAIT_S",),
    "rigctl.rig.machine": ("_DEVICES_WAIT_S",),
    "rigctl.sweeps.runner": ("PAUSE_WAIT_S",),
}
"""Longest waits of the daemon for its own threads and lines, by module."""


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no wait of the daemon run out because the machine is busy.

    A test holds a line or a lock for as long as its other thread takes. One of a bound sets it.
    """
    for module, names in WAITS.items():
        if (loaded := sys.modules.get(module)) is not None:
            for name in names:
                monkeypatch.setattr(loaded, name, 60.0)


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = Store(tmp_path / "data")
    yield opened
    opened.close()
