"""What one rig is made of."""

from __future__ import annotations

from dataclasses import dataclass

from rigctl.cameras.capture import Capture
from rigctl.config import Configuration
from rigctl.devices.roles import CutOff, Regulator, Slide, Trigger
from rigctl.rig.clock import Clock
from rigctl.store.store import Store


@dataclass(frozen=True, slots=True)
class RigDevices:
    """What the rig acts through; the release apparatus has neither regulator nor slide."""

    trigger: Trigger
    regulator: Regulator | None
    slide: Slide | None
    cut_off: CutOff


@dataclass(frozen=True, slots=True)
class Bench:
    """Everything that stays the same from one shot to the next."""

    configuration: Configuration
    devices: RigDevices
    capture: Capture
    store: Store
    clock: Clock
