"""The rig as a device of Bluesky (extra `bluesky`), and the plan that fires one shot once.

Nothing here is in the way of firing: it speaks REST to the daemon, as any other caller does.
"""

from rigctl.bluesky_devices.plans import fire_once, one_shot
from rigctl.bluesky_devices.rig import Rig
from rigctl.bluesky_devices.step import Step

__all__ = ["Rig", "Step", "fire_once", "one_shot"]
