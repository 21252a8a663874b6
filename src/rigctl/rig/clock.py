"""Time, handed in so that tests can turn it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime


def _utc() -> datetime:
    return datetime.now(UTC)


@dataclass(frozen=True, slots=True)
class Clock:
    """Monotonic seconds for bounds and ages, wall time (UTC) for the record, and a wait in s."""

    monotonic: Callable[[], float] = time.monotonic
    wall: Callable[[], datetime] = _utc
    wait: Callable[[float], None] = time.sleep


SYSTEM_CLOCK = Clock()
"""The machine's own clocks."""
