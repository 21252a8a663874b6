"""Plans that fire.

A run engine that is paused goes back to its last checkpoint when it resumes, and does again what
was done since. A shot cannot be done again. So the checkpoint is cleared before the rig is armed,
which holds to the end of the plan: a pause ends the run, and one that is deferred ends it between
two shots. What is to be paused and resumed is a sweep of the daemon's own.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import bluesky.plan_stubs as bps
from bluesky.utils import MsgGenerator

from rigctl.bluesky_devices.rig import Rig
from rigctl.bluesky_devices.step import Step
from rigctl.settings import ShotSettings


def one_shot(rig: Rig, settings: ShotSettings) -> MsgGenerator[None]:
    """Arm, fire once and record the shot as an event, within a run that is open."""
    step = Step(settings)
    # Here a pause that was deferred takes effect: the shot before is on record, nothing is armed.
    yield from bps.checkpoint()
    yield from bps.clear_checkpoint()
    yield from bps.abs_set(rig, step, wait=True)
    yield from bps.trigger(rig, wait=True)
    yield from bps.create("primary")
    yield from bps.read(rig)
    yield from bps.save()


def fire_once(
    rig: Rig, settings: ShotSettings, *, md: Mapping[str, Any] | None = None
) -> MsgGenerator[str]:
    """Fire one shot as a run of its own.

    Parameters
    ----------
    md
        Further metadata of the run.

    Returns
    -------
    The identifier of the run. A run engine closes the run by itself when something fails.
    """
    about = {"plan_name": "fire_once", "detectors": [rig.name], **(md or {})}
    about["settings"] = settings.model_dump(exclude_none=True)
    yield from bps.stage(rig)
    run: str = yield from bps.open_run(about)
    yield from one_shot(rig, settings)
    yield from bps.close_run()
    yield from bps.unstage(rig)
    return run
