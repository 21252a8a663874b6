"""The rig as a device of Bluesky (extra `bluesky`), and the plan that fires one shot once.

These devices use REST, as any other client of the daemon does; firing does not depend on them.
"""

from rigctl.bluesky_devices.plans import fire_once, one_shot
from rigctl.bluesky_devices.rig import Rig
from rigctl.bluesky_devices.step import Step

__all__ = ["Rig", "Step", "fire_once", "one_shot"]
