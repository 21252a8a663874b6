"""One store in a folder of its own, and shots to put into it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from rigctl.cameras.frames import FrameSequence
from rigctl.settings import ShotSettings
from rigctl.store import NewShot, ShotRecord, Store


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = Store(tmp_path / "data", busy_timeout_s=0.05)
    yield opened
    opened.close()


@pytest.fixture
def new_shot() -> Callable[..., NewShot]:
    def make(**changes: object) -> NewShot:
        fields = {
            "settings": ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=41.0, offset_mm=6.0),
            "campaign": "nylon",
            "note": None,
            "actor": "anna",
            "simulated": True,
            "configuration": "c0ffee",
            "accepted_at": datetime(2026, 1, 31, 23, 59, tzinfo=UTC),
        }
        return NewShot(**{**fields, **changes})

    return make


@pytest.fixture
def accepted(store: Store, new_shot: Callable[..., NewShot]) -> Callable[..., ShotRecord]:
    def accept(key: str = "key", **changes: object) -> ShotRecord:
        return store.accept(key, "body", lambda: new_shot(**changes))[0]

    return accept


@pytest.fixture
def frames() -> FrameSequence:
    chance = np.random.default_rng(7)
    return FrameSequence(
        pixels=chance.integers(0, 256, (5, 16, 24), dtype=np.uint8),
        times_s=np.array([0.1, 0.101, 0.102, 0.104, 0.105]),
        sequence=np.array([100, 101, 102, 104, 105], dtype=np.int64),
        lost=(103,),
        source="stand-in",
    )
