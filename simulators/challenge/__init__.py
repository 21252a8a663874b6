"""Campaigns that hide an effect: physics of their own, poses with noise, and a sealed label.

Everything is SI and in rig axes, as in `simulators.world`. Arrays run over shots, then frames,
then spheres (a, b).
"""

from simulators.challenge.effects import HIDDEN
from simulators.challenge.making import new_challenge, write_challenge

__all__ = ["HIDDEN", "new_challenge", "write_challenge"]
