"""What one rig is made of."""

from __future__ import annotations

from dataclasses import dataclass

from rigctl.cameras.capture import Capture
from rigctl.config import Configuration
from rigctl.devices.roles import Actuators
from rigctl.rig.clock import Clock
from rigctl.store.store import Store


@dataclass(frozen=True, slots=True)
class Bench:
    """Everything that stays the same from one shot to the next."""

    configuration: Configuration
    devices: Actuators
    capture: Capture
    store: Store
    clock: Clock
