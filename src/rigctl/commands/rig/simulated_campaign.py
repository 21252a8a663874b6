"""A campaign fired on the simulated rig inside this process, and measured."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Literal

from rigctl.commands.rig.local import LocalRig
from rigctl.commands.rig.shot import measured
from rigctl.config import Configuration, Simulation, load
from rigctl.daemon import Daemon
from rigctl.settings import ShotSettings

FACTORY = "simulators.laboratory:open_laboratory"
FRAMES_AFTER_MARK = 90
"""The slowest of these shots meet 60 ms after the fire."""
LONGEST_COLLECTION_S, LONGEST_ANALYSIS_S = 60.0, 300.0
"""On a machine that is busy with other things, or compiles."""


def simulated(
    folder: Path, method: Literal["thesis", "photometric"], *, seed: int, hides: str | None = None
) -> Configuration:
    """Return the simulated rig's configuration with its store in a folder.

    Parameters
    ----------
    method
        How its shots are measured.
    seed
        Draws the scatter of the launches, the camera's noise, and the hidden effect if it is
        `"drawn"`.
    hides
        What the simulated world hides, as in the configuration's `[simulation]`.
    """
    usual = load(None)
    simulation = {"factory": FACTORY, "seed": seed} | ({"hides": hides} if hides else {})
    camera = {
        "frames_after_mark": FRAMES_AFTER_MARK,
        "collect_timeout_s": LONGEST_COLLECTION_S,
    }
    return usual.model_copy(
        update={
            "simulation": Simulation.model_validate(simulation),
            "store": usual.store.model_copy(update={"folder": str(folder)}),
            "analysis": usual.analysis.model_copy(update={"method": method}),
            "camera": usual.camera.model_copy(update=camera),
        }
    )


def fire_all(
    daemon: Daemon,
    campaign: str,
    settings: Iterable[tuple[float, float]],
    say: Callable[[str], None],
) -> list[str]:
    """Fire one shot after another; return their names. Stored ones are measured meanwhile.

    Parameters
    ----------
    settings
        Pressure, kPa, and offset, mm, of each shot.
    """
    rig, names, wanted = LocalRig(daemon, campaign), [], list(settings)
    for number, (pressure, offset) in enumerate(wanted, start=1):
        say(f"shot {number} of {len(wanted)}")
        token = rig.arm(
            ShotSettings(pressure_a_kpa=pressure, pressure_b_kpa=pressure, offset_mm=offset)
        )
        # Each shot has one key, so that none can fire twice.
        names.append(rig.fire(token, f"{campaign}-{number}", campaign))
        daemon.rig.wait(names[-1])
    return names


def measurements(daemon: Daemon, names: Iterable[str]) -> list[dict[str, Any]]:
    """Wait for the measurements of shots; return the shots with their results."""
    rig = LocalRig(daemon, "measurements")
    return [measured(rig, name, LONGEST_ANALYSIS_S) for name in names]
