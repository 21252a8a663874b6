"""The world behind the simulated rig: two spheres, two tubes, a contact and a camera.

Everything is SI and in rig axes: X down, Y right, Z toward the camera, right-handed. Sphere a
leaves the left tube toward +Y, sphere b the right tube toward -Y. Quaternions are scalar first
and rotate body axes into rig axes.
"""

from simulators.world.description import WorldDescription
from simulators.world.exchange import write_campaign
from simulators.world.launch import Launch
from simulators.world.shots import RenderedShot, render_shot
from simulators.world.world import World

__all__ = [
    "Launch",
    "RenderedShot",
    "World",
    "WorldDescription",
    "render_shot",
    "write_campaign",
]
