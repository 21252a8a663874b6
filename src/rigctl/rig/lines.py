"""Opens lost lines again: before arming and on a release, never on the way to a fire."""

from __future__ import annotations

import logging

from rigctl.devices.roles import Actuators
from rigctl.errors import RigError
from rigctl.rig.stopping.estop import EmergencyStop

_log = logging.getLogger(__name__)


def reopen(devices: Actuators, stop: EmergencyStop) -> None:
    """Open every line again that was lost, the cut-off's in the thread that owns it.

    Never raises a `RigError`: a line that stays away is named by whatever next needs it.
    """
    for part in (stop, devices.trigger, devices.regulator, devices.slide):
        if part is None:
            continue
        try:
            part.reopen()
        except RigError as error:
            _log.warning("a line was not opened again: %s", error)
