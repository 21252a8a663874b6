"""Fire a shot with a rig behind a daemon or in this process, and wait for its measurement."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from rigctl.rig.arming import Armed
from rigctl.settings import ShotSettings

ON_THE_WAY = frozenset({"accepted", "firing", "capturing", "stored", "analysing"})
"""States of a shot that will get another."""
_POLL_S = 0.1


class Operable(Protocol):
    """A rig to fire a shot with: behind a running daemon, or inside this process."""

    def arm(self, settings: ShotSettings) -> Armed:
        """Set the rig and return token and warnings."""

    def fire(self, token: str, key: str, campaign: str | None) -> str:
        """Fire once under this idempotency key and return the shot's id."""

    def shot(self, shot: str) -> Mapping[str, Any]:
        """Return the shot as REST shows it."""

    def result(self, shot: str) -> Mapping[str, Any]:
        """Return the shot's measurement; raise `NotFoundError` while there is none."""


def fire_and_wait(
    rig: Operable,
    settings: ShotSettings,
    campaign: str | None,
    wait_s: float,
    progress: Callable[[str], None],
    *,
    warn: Callable[[str], None] = lambda _: None,
    compiling: Callable[[], str | None] = lambda: None,
    clock: Callable[[], float] = time.monotonic,
    pause: Callable[[float], None] = time.sleep,
) -> dict[str, Any]:
    """Fire one shot and return it as REST shows it, with its measurement under `result`.

    The measurement is waited for at most `wait_s`, counted from the end of compiling where it has
    to wait for that; `result` is None when there is none. `warn` is called before the fire, with
    what the rig says when it is armed. `compiling` says how far the compiler is, None where nothing
    is compiled; the analysis bounds that by itself.
    """
    progress("setting pressure and offset")
    armed = rig.arm(settings)
    for warning in armed.warnings:
        warn(warning)
    progress("firing")
    name = rig.fire(armed.token, str(uuid.uuid4()), campaign)
    progress(f"shot {name}: waiting for its measurement")

    def far() -> str | None:
        words = compiling()
        if words is not None:
            progress(f"shot {name}: {words}")
        return words

    return measured(rig, name, wait_s, compiling=far, clock=clock, pause=pause)


def measured(
    rig: Operable,
    name: str,
    wait_s: float,
    *,
    compiling: Callable[[], str | None] = lambda: None,
    clock: Callable[[], float] = time.monotonic,
    pause: Callable[[float], None] = time.sleep,
) -> dict[str, Any]:
    """Wait for the measurement of a fired shot, as `fire_and_wait`, and return the same."""
    deadline = clock() + wait_s
    record = rig.shot(name)
    while record["state"] in ON_THE_WAY and clock() < deadline:
        pause(_POLL_S)
        if compiling() is not None:
            deadline = clock() + wait_s
        record = rig.shot(name)
    ended = record["state"] in {"analysed", "refused"}
    return {**record, "result": rig.result(name) if ended else None}
