"""A stored campaign and workers that are there at once, for tests of what analyses it once more."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from concurrent.futures import Executor, Future
from datetime import UTC, datetime
from typing import Any

import numpy as np

from rigctl.cameras.frames import FrameSequence
from rigctl.reanalysis import Outcome, Pool, reanalyse_campaign
from rigctl.settings import ShotSettings
from rigctl.store import Change, NewShot, ShotState, Store

Json = dict[str, Any]
NOW = datetime(2026, 1, 31, 12, tzinfo=UTC)
SETTINGS = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0)


class Inline(Executor):
    """Does the work at once, and counts it."""

    def __init__(self) -> None:
        self.done: list[str] = []

    def submit(self, call: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        future = Future[Any]()
        self.done.append(call.__name__)
        try:
            future.set_result(call(*given, **named))
        except Exception as error:  # noqa: BLE001 - it is told by the future
            future.set_exception(error)
        return future


def firing(store: Store) -> str:
    new = NewShot(SETTINGS, "nylon", None, "anna", True, "c0ffee", NOW)
    record, _ = store.accept(str(uuid.uuid4()), "body", lambda: new)
    return store.move(record.id, ShotState.FIRING).id


def stored(store: Store) -> str:
    shot = firing(store)
    store.move(shot, ShotState.CAPTURING)
    pixels = np.zeros((2, 8, 8), dtype=np.uint8)
    frames = FrameSequence(pixels, np.arange(2) / 1e3, np.arange(2), (), "test")
    store.folders.write(shot, frames, {"shot": shot})
    store.move(shot, ShotState.STORED, Change(frames=2))
    return shot


def measured(e: float, sigma: float | None = 0.01) -> Json:
    return {"status": "measured", "e": {"value": e, "sigma": sigma, "unit": "1"}}


def reanalysed(
    store: Store, campaign: str, method: str, executor: Executor | None = None
) -> list[Outcome]:
    """Analyse a campaign once more by one worker, to its end."""
    pool = Pool(executor or Inline(), lambda: 1)
    return list(reanalyse_campaign(store, campaign, method, pool, silent))


def silent(_text: str, _share: float | None) -> None:
    """Say nothing."""
