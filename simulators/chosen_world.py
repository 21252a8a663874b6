"""The world of a laboratory as its options choose it, and what is hidden in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from simulators.bench import BenchWorld
from simulators.options import DRAWN, Options
from simulators.world import Launch, World, WorldDescription
from simulators.world.release import Release

# Above the numbers that the world gives its own chances.
_LABEL, _SALT = 100, 101
LASTING = "lasting-contact"
"""What every contact of the rig has: an answer may name it beside what is hidden."""


class Filmed(Protocol):
    """What the outputs act on and the recorder sees."""

    @property
    def fires(self) -> int:
        """How often it was launched."""

    def fire(self, launch: Launch | Release, /) -> int:
        """Launch, and return the number of the shot."""

    def picture(self, time_s: float, rows: int | None = None) -> NDArray[np.uint8]:
        """Return the frame with mid-exposure at a lab time."""


def world_of(options: Options, truth: Path, position_mm: Callable[[float], float]) -> Filmed:
    """Return the world of the options, with what is hidden on top, its label sealed."""
    if options.bench is not None:
        return BenchWorld(options.bench, options.seed, position_mm)
    if not options.hides:
        return World(options.world, options.seed, truth)
    if options.world != WorldDescription(optics=options.world.optics):
        raise ValueError(
            f"simulation.hides is {options.hides!r}, which acts between the nylon rig's spheres;"
            " leave spheres, environment and the tables contact, tube and air at nylon's"
        )
    # Slow to load, and of no use to a laboratory that hides nothing.
    from simulators.challenge.effects import switched  # noqa: PLC0415
    from simulators.challenge.force_choice import Forces  # noqa: PLC0415
    from simulators.challenge.label import draw_in_contact, label_document  # noqa: PLC0415
    from simulators.challenge.law import contact_law  # noqa: PLC0415
    from simulators.challenge.seal import write_seal  # noqa: PLC0415

    named = None if options.hides == DRAWN else options.hides
    hidden = draw_in_contact(np.random.default_rng([options.seed, _LABEL]), named)
    law = contact_law(replace(switched(hidden), forces=Forces()))
    world = World(options.world, options.seed, truth, law)
    label = label_document(hidden, world=[LASTING])
    write_seal(truth, label, np.random.default_rng([options.seed, _SALT]))
    return world
