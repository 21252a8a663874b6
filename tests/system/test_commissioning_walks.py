"""Every apparatus that fires is walked through whole: the daemon sees what each step must show."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from rigctl import daemon as daemons
from rigctl.commissioning.step import Step
from rigctl.commissioning.steps import steps_of
from rigctl.commissioning.walk import Acts, Found
from rigctl.config import Configuration, StoreSection, load
from rigctl.daemon import Daemon, open_daemon
from rigctl.rig.clock import SYSTEM_CLOCK, Clock
from rigctl.rig.machine import Rig

CONFIG = Path(__file__).parents[2] / "config"
SIMULATED = "sim:"


class Hands:
    """Who stands at the simulated rig, and sets the host's clock."""

    def __init__(self) -> None:
        self.clock_s = 0.0

    def wall(self) -> datetime:
        return SYSTEM_CLOCK.wall() + timedelta(seconds=self.clock_s)

    def do(self, step: Step, configuration: Configuration, laboratory: Any) -> None:
        """Do what a step says; what an earlier one said is undone."""
        laboratory.clear_faults()
        laboratory.move_switch(step.name != "own-switch")
        self.clock_s = 60.0 if step.name == "clock" else 0.0
        cable, _, said = step.name.rpartition("-")
        if said == "unplugged":
            ports = {"trigger": configuration.trigger.port, "camera": "recorder"}
            laboratory.fault(ports.get(cable, cable).removeprefix(SIMULATED), "unplug")
        if step.name == "remote-trigger":
            laboratory.fault("recorder", "never-starts")


@contextmanager
def at_the_rig(name: str, folder: Path) -> Iterator[tuple[Daemon, Configuration, Hands]]:
    configuration = load(CONFIG / f"{name}.toml")
    camera = configuration.camera.model_copy(update={"frames_after_mark": 15})
    store = StoreSection(folder=str(folder / "data"))
    short = configuration.model_copy(update={"camera": camera, "store": store})
    hands = Hands()
    clock = Clock(SYSTEM_CLOCK.monotonic, hands.wall, SYSTEM_CLOCK.wait)
    with (
        mock.patch.object(daemons, "Rig", partial(Rig, clock=clock)),
        open_daemon(short) as daemon,
    ):
        yield daemon, short, hands


@pytest.mark.long
@pytest.mark.parametrize("name", ["simulated", "simulated-release", "simulated-plate"])
@pytest.mark.timeout(600)
def test_the_daemon_sees_what_every_step_must_show(name: str, tmp_path: Path) -> None:
    missed: list[str] = []
    with at_the_rig(name, tmp_path) as (daemon, configuration, hands):
        acts = Acts(daemon.rig, SYSTEM_CLOCK)
        for step in steps_of(configuration):
            hands.do(step, configuration, daemon.laboratory)
            found: Found = acts.perform(step, "anna")
            if not found.holds:
                missed.append(f"{step.name}: {found.text}")
        assert daemon.rig.status().latch_reason is None
    assert missed == []
