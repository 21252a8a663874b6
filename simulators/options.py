"""What a configuration may choose about the simulated laboratory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from simulators.bench import APPARATUS, BenchScene
from simulators.ektapro.processor import RUN_UP_S
from simulators.wire.alicat import LAG_S
from simulators.wire.zaber import SPEED_MM_PER_S
from simulators.world import WorldDescription
from simulators.world.scene import described

IN_CONTACT = (
    "friction-speed",
    "inertia-factor",
    "mass-mismatch",
    "restitution-obliquity",
    "restitution-plastic",
    "restitution-viscoelastic",
    "torsional-friction",
)
"""Effects that act while the spheres touch, whenever and wherever that is, on top of a contact that
lasts."""
LAWS_IN_CONTACT = (
    "friction-exponential",
    "friction-spin",
    "restitution-bump",
    "restitution-grain",
)
"""Laws that no catalogue holds and that need nothing but how the spheres meet; never drawn."""


@dataclass(frozen=True, slots=True)
class Options:
    """Options of the `[simulation]` table.

    Attributes
    ----------
    seed
        Of every random number in the world.
    pressure_lag_s
        Time constant of the regulators in seconds.
    slide_speed_mm_per_s
        Speed of the slide.
    run_up_s
        Time from RECORD to the recorder's first picture in seconds.
    watch_contact
        The trigger box's watch opens a contact in the line of the actuators' power.
    hides
        One of `HIDES`. Empty: spheres of nylon in still air. Else one effect comes on top in their
        contact: that of this name, or the one that the seed draws.
    holds_energised
        Whether solenoids hold with current, as the scene's trigger says.
    bench
        A stage or a disk in the place of the world; None: spheres that are launched.
    world
        What the configuration describes and the tables `contact`, `tube`, `magnet` and `air` change
        (`simulators.world.scene.described`).
    """

    seed: int = 1
    pressure_lag_s: float = LAG_S
    slide_speed_mm_per_s: float = SPEED_MM_PER_S
    run_up_s: float = RUN_UP_S
    watch_contact: bool = False
    hides: str = ""
    holds_energised: bool = True
    bench: BenchScene | None = None
    world: WorldDescription = field(default_factory=WorldDescription)


OF_DIAMETERS = 41
"""Stream of random numbers for the true diameters of the spheres."""
WORLD_TABLES = ("scene", "contact", "tube", "magnet", "air")
"""Tables that describe the world; `scene` is what the rig's own configuration says of it."""
DRAWN = "drawn"
HIDES = ("", DRAWN, *IN_CONTACT, *LAWS_IN_CONTACT)

_LIMITS: Mapping[str, tuple[float, float]] = {
    "seed": (0, 2**63 - 1),
    "pressure_lag_s": (1e-4, 10.0),
    "slide_speed_mm_per_s": (0.1, 10_000.0),
    "run_up_s": (0.0, 10.0),
}


def read_options(table: Mapping[str, object]) -> Options:
    """Check the options of a configuration.

    Raises
    ------
    ValueError
        An unknown option, or a value of the wrong kind or outside its limits; the option is named.
    """
    own = {each.name for each in fields(Options)} - {"world", "holds_energised", "bench"}
    known = own | {*WORLD_TABLES}
    for name, value in table.items():
        if name not in known:
            raise ValueError(
                f"simulation.{name} is no option; there are {', '.join(sorted(known))}"
            )
        if name in WORLD_TABLES:
            if not isinstance(value, Mapping):
                raise ValueError(f"simulation.{name} is {value!r}; it is a table")
            continue
        if name == "hides":
            if value not in HIDES:
                raise ValueError(f"simulation.hides is {value!r}; allowed {', '.join(HIDES[1:])}")
            continue
        if name == "watch_contact":
            if not isinstance(value, bool):
                raise ValueError(f"simulation.{name} is {value!r}; allowed true and false")
            continue
        low, high = _LIMITS[name]
        kinds = int if name == "seed" else (int, float)
        if not isinstance(value, kinds) or isinstance(value, bool) or not low <= value <= high:
            raise ValueError(f"simulation.{name} is {value!r}; allowed {low} to {high}")
    plain = {name: value for name, value in table.items() if name not in WORLD_TABLES}
    tables: dict[str, Any] = {name: table.get(name, {}) for name in WORLD_TABLES}
    scene = tables.pop("scene")
    if scene.get("apparatus") in APPARATUS:
        return Options(**plain, bench=BenchScene.of(scene))  # type: ignore[arg-type]
    holds = scene.get("energised", "hold") == "hold"
    options = Options(**plain, holds_energised=holds)  # type: ignore[arg-type]  # each value was checked above
    # What is hidden acts between spheres that are just as stated.
    rng = None if options.hides else np.random.default_rng([options.seed, OF_DIAMETERS])
    return replace(options, world=described(scene, **tables, rng=rng))
