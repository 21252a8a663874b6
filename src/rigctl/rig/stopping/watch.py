"""What acts in the place of the daemon when it dies or hangs: a process, or the trigger box."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class Watch(Protocol):
    """What takes the power, or makes a device safe, when this process no longer can."""

    def start(self, alive: Callable[[], bool], tripped: Callable[[str], None]) -> None:
        """Begin to watch, unless it does already; raise a `DeviceError` where it cannot."""

    def end(self) -> None:
        """Watch no more: what is safe by now stays safe."""
