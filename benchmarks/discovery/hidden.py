"""Effects hidden on top of the rig's contact, in poses as exact as filmed ones, and none at all.

Poses err as is stated of films: freshly, slowly, and all alike by scale, outlines, orientations
and drag. The slow errors are those of --slow-px, while half and twice as much are stated in turn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from benchmarks.discovery.filmed_errors import filmed
from benchmarks.discovery.lasting import HIDDEN, PLAIN, STATED_DRAG, tell
from benchmarks.discovery.options import Options
from simulators.challenge import HIDDEN as EFFECTS
from simulators.challenge.effects import switched
from simulators.challenge.nature import Nature

FIRST_SEED = 950
SLOW_PX = 0.001
MISSTATED = (0.5, 2.0)
OTHERS_IN_CONTACT = ("friction-speed", "inertia-factor", "restitution-obliquity")
"""What a laboratory's challenge may hide besides."""
WORLDS: Mapping[str, Nature] = {
    "nothing": PLAIN,
    "nothing, again": PLAIN,
    **HIDDEN,
    **{
        name: replace(
            switched({name: EFFECTS[name].amplitude}),
            forces=PLAIN.forces,
            drag_coefficient=PLAIN.drag_coefficient,
        )
        for name in OTHERS_IN_CONTACT
    },
}


def run(options: Options) -> None:
    """Print what becomes of every campaign."""
    print(f"{'world':24} {'hidden':26} chi2   left out  seconds  verdict")
    slow_px = SLOW_PX if options.slow_px is None else options.slow_px
    for k, (name, nature) in enumerate(WORLDS.items()):
        data = filmed(nature, FIRST_SEED + k, options.shots, slow_px, by_place=options.by_place)
        wrong = MISSTATED[k % len(MISSTATED)]
        slow = replace(
            data.slow,
            position_m=wrong * data.slow.position_m,
            rotation_rad=wrong * data.slow.rotation_rad,
        )
        tell("rig's own, filmed", name, replace(data, slow=slow, drag_coefficient=STATED_DRAG))
