"""One shot as a plan orders it, and its progress."""

from __future__ import annotations

import uuid
from dataclasses import dataclass, field

from rigctl.settings import ShotSettings


@dataclass(frozen=True, slots=True)
class Step:
    """Settings, and the idempotency key under which they are fired.

    A run engine that rewinds hands the same message, and with it the same step, to the device
    again: the key is made where the plan makes the step, never where it is carried out.
    """

    settings: ShotSettings
    key: str = field(default_factory=lambda: str(uuid.uuid4()))


@dataclass(slots=True)
class Progress:
    """How far the device has come with a step; its owner's lock guards it.

    Attributes
    ----------
    token
        Of the rig that is armed for it.
    sent
        Whether the fire command was sent: from then on it is never sent again, whatever comes.
    shot
        The shot it became, once the daemon has named it.
    """

    token: str | None = None
    sent: bool = False
    shot: str | None = None
