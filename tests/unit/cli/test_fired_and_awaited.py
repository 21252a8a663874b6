"""A shot that a command fires: once, and its measurement awaited."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from rigctl.cli.rig.shot import settings_of
from rigctl.firing import fire_and_wait
from rigctl.rig.arming import Armed


class Bench:
    """A rig whose shot goes through the given states, one for each time it is asked."""

    def __init__(self, states: list[str]) -> None:
        self._states = states
        self.fired: list[tuple[str, str, str | None]] = []

    def arm(self, settings: object) -> Armed:
        return Armed("token", datetime(2026, 1, 31, tzinfo=UTC), 10.0, ("keep clear",))

    def fire(self, token: str, key: str, campaign: str | None) -> str:
        self.fired.append((token, key, campaign))
        return "20260131-000001"

    def shot(self, shot: str) -> Mapping[str, Any]:
        state = self._states.pop(0) if len(self._states) > 1 else self._states[0]
        return {"shot": shot, "state": state, "failure": None}

    def result(self, shot: str) -> Mapping[str, Any]:
        return {"e": {"value": 0.74, "sigma": 0.01, "unit": "1"}}


SETTINGS = settings_of(None, pressure_a_kpa=40, pressure_b_kpa=40, offset_mm=6, angle_a_deg=None)


def test_a_shot_is_fired_once_and_its_measurement_awaited() -> None:
    bench = Bench(["accepted", "capturing", "stored", "analysing", "analysed"])
    waited: list[float] = []
    warned: list[tuple[str, int]] = []
    document = fire_and_wait(
        bench,
        SETTINGS,
        "nylon-1",
        60.0,
        lambda _: None,
        warn=lambda text: warned.append((text, len(bench.fired))),
        clock=lambda: sum(waited),
        pause=waited.append,
    )
    assert document["state"] == "analysed"
    assert document["result"]["e"]["value"] == 0.74
    ((token, key, campaign),) = bench.fired
    assert (token, campaign, len(key)) == ("token", "nylon-1", 36)
    assert warned == [("keep clear", 0)], "before the fire"
    assert len(waited) == 4


def test_the_wait_for_a_measurement_has_an_end() -> None:
    bench = Bench(["stored"])
    waited: list[float] = []
    document = fire_and_wait(
        bench,
        SETTINGS,
        None,
        2.0,
        lambda _: None,
        clock=lambda: sum(waited),
        pause=waited.append,
    )
    assert (document["state"], document["result"]) == ("stored", None)
    assert 2.0 <= sum(waited) < 2.2
    assert len(bench.fired) == 1


def test_the_wait_begins_when_the_compiler_has_ended() -> None:
    """A first shot waits as long as compiling takes, and says how far that is."""
    bench = Bench(["analysing"] * 200 + ["analysed"])
    waited: list[float] = []
    said: list[str] = []
    document = fire_and_wait(
        bench,
        SETTINGS,
        None,
        2.0,
        said.append,
        compiling=lambda: "compiling, 40 %" if sum(waited) < 19.0 else None,
        clock=lambda: sum(waited),
        pause=waited.append,
    )
    assert document["state"] == "analysed"
    assert sum(waited) > 19.0
    assert said[-1].endswith("compiling, 40 %")


def test_two_shots_never_share_a_key() -> None:
    bench = Bench(["misfire"])
    for _ in range(2):
        fire_and_wait(bench, SETTINGS, None, 1.0, lambda _: None)
    assert bench.fired[0][1] != bench.fired[1][1]
