"""A rig that counts its fires, and breaks off where a test says so."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from rigctl.errors import RigError
from rigctl.rig.arming import Armed
from rigctl.settings import ShotSettings

SETTINGS = ShotSettings(pressure_a_kpa=40, pressure_b_kpa=40, offset_mm=6)
RESULT = {
    "e": {"value": 0.74, "sigma": 0.001, "unit": "1"},
    "v_n": {"value": -3.1, "sigma": 0.002, "unit": "m/s"},
    "beta": None,
}


def nothing() -> None:
    """Do nothing."""


@dataclass
class CountingRig:
    """What a device asks of a daemon; `while_arming` and `while_firing` are called inside."""

    while_arming: Callable[[], None] = nothing
    while_firing: Callable[[], None] = nothing
    loses_the_answer: bool = False
    armed: list[ShotSettings] = field(default_factory=list)
    fires: list[tuple[str, str]] = field(default_factory=list)

    def arm(self, settings: ShotSettings) -> Armed:
        self.armed.append(settings)
        self.while_arming()
        return Armed(f"token-{len(self.armed)}", datetime(2026, 1, 31, tzinfo=UTC), 10.0)

    def fire(self, token: str, key: str, campaign: str | None) -> str:
        self.fires.append((token, key))
        self.while_firing()
        if self.loses_the_answer:
            raise RigError("the daemon's answer to POST /shots was lost")
        return f"shot-{len(self.fires)}"

    def shot(self, shot: str) -> Mapping[str, Any]:
        return {
            "shot": shot,
            "state": "analysed",
            "settings": self.armed[-1].model_dump(),
            "accepted_at": "2026-01-31T12:00:00+00:00",
            "fired_at": "2026-01-31T12:00:01+00:00",
        }

    def result(self, shot: str) -> Mapping[str, Any]:
        return RESULT
