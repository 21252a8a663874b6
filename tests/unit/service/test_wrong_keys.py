"""Whoever tries keys waits longer and longer; nobody else does, and no stop ever."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from rigctl.access.wrong_keys import LONGEST_S, MANY, WITHIN_S, WrongKeys
from rigctl.store import Store


class Bench:
    """A count whose clock only the test moves, and that notes how long anybody waits."""

    def __init__(self) -> None:
        self.now, self.waits, self.told = 0.0, list[float](), list[str]()
        self.wrong = WrongKeys(self.told.append, lambda: self.now, self._sleep)

    async def _sleep(self, seconds: float) -> None:
        self.waits.append(seconds)

    def try_key(self, address: str = "10.0.0.7") -> None:
        asyncio.run(self.wrong.refuse(address))


def test_ten_wrong_keys_are_answered_at_once_and_further_ones_later_and_later() -> None:
    bench = Bench()
    for _ in range(MANY):
        bench.try_key()
    assert (bench.waits, bench.told) == ([], [])
    for _ in range(20):
        bench.try_key()
    assert bench.waits[:5] == [0.25, 0.5, 1.0, 2.0, 4.0]
    assert max(bench.waits) == LONGEST_S
    assert bench.told == ["10.0.0.7"]
    assert bench.wrong.count == 30


def test_another_address_does_not_wait_and_neither_does_one_that_was_silent() -> None:
    bench = Bench()
    for _ in range(MANY):
        bench.try_key()
    bench.try_key("10.0.0.8")
    bench.now = WITHIN_S + 1
    bench.try_key()
    assert bench.waits == []


def test_keys_that_come_slowly_are_only_counted() -> None:
    bench = Bench()
    for _ in range(50):
        bench.now += WITHIN_S / (MANY - 1)
        bench.try_key()
    assert (bench.waits, bench.wrong.count) == ([], 50)


def test_however_many_addresses_try_memory_has_a_bound() -> None:
    bench = Bench()
    for n in range(3000):
        bench.wrong.note(f"10.0.{n // 256}.{n % 256}")
    assert len(bench.wrong._times) == 1000


@pytest.fixture
def quick(app: Any, monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Let nobody really wait; return for how long each would have."""
    waits: list[float] = []

    async def sleep(seconds: float) -> None:
        waits.append(seconds)

    monkeypatch.setattr(app.state.wrong_keys, "_sleep", sleep)
    return waits


def test_the_service_counts_slows_down_and_says_from_where(
    ask: Any, store: Store, rig: Any, quick: list[float]
) -> None:
    for _ in range(MANY + 2):
        assert ask("GET", "/api/v1/rig", key="wrong").status_code == 401
    assert quick == [0.25, 0.5]
    assert ask("GET", "/api/v1/rig").status_code == 200
    assert ask("POST", "/api/v1/rig/estop", key="wrong").status_code == 200
    assert len(quick) == 2
    assert len(rig.stops) == 1
    assert ask("GET", "/health/ready").json().get("wrong_keys", 13) == 13


def test_who_sends_no_key_at_all_is_refused_and_not_counted(
    ask: Any, app: Any, quick: list[float]
) -> None:
    for _ in range(20):
        ask("GET", "/api/v1/rig", key=None)
    assert (app.state.wrong_keys.count, quick) == (0, [])


def test_the_audit_names_the_address(store: Store) -> None:
    store.edits.wrong_keys("10.0.0.7", "10 within 60 s")
    (entry,) = store.edits.entries()
    assert (entry.act, entry.subject, entry.after) == ("wrong keys", "10.0.0.7", "10 within 60 s")
