"""What tests of several rooms start from."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from rigctl.store import Store
from tests.simulated import wait_long


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no wait of the daemon run out because the machine is busy.

    A test holds a line or a lock for as long as its other thread takes. One of a bound sets it.
    """
    wait_long(monkeypatch)


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = Store(tmp_path / "data")
    yield opened
    opened.close()
