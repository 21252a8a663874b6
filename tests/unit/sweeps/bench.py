"""One rig of stand-ins with its sweep runner; `start_again` is a daemon that ended clean."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from pathlib import Path

from rig_fakes import Laboratory

from rigctl.settings import ShotSettings
from rigctl.store import Change, ShotState, StepRecord, SweepState
from rigctl.sweeps.plan import Plan, Rules
from rigctl.sweeps.runner import SweepRunner
from rigctl.sweeps.status import SweepStatus

BOUND_S = 120.0


def settings(offset_mm: float, pressure_kpa: float = 40.0) -> ShotSettings:
    return ShotSettings(
        pressure_a_kpa=pressure_kpa, pressure_b_kpa=pressure_kpa, offset_mm=offset_mm
    )


def plan(offsets: Sequence[float] = (1.0, 2.0, 3.0), rules: Rules | None = None) -> Plan:
    steps = tuple(settings(offset) for offset in offsets)
    return Plan(steps, Rules() if rules is None else rules, "{}", "nylon")


class Bench:
    """Laboratory and runner; nothing in it waits but `wait` itself, within a bound."""

    def __init__(self, folder: Path) -> None:
        self.lab = Laboratory(folder)
        self.idled: list[float] = []
        self.on_idle: Callable[[], None] = lambda: None
        self._open()

    def _open(self) -> None:
        self.runner = SweepRunner(
            self.lab.rig,
            self.lab.store,
            self.lab.configuration,
            clock=self.lab.time.clock(),
            idle=self.idle,
        )
        self.offered = self.runner.recover()

    def idle(self, _: threading.Event, seconds: float) -> None:
        self.idled.append(seconds)
        self.lab.time.pass_time(seconds)
        self.on_idle()

    def start(self, wanted: Plan | None = None, key: str = "key", body: str = "body") -> str:
        started = self.runner.start(wanted or plan(), key, body, "anna")
        return started.record.id

    def run(self, wanted: Plan | None = None, key: str = "key") -> SweepStatus:
        sweep = self.start(wanted, key)
        return self.wait(sweep)

    def resume(self, sweep: str) -> SweepStatus:
        self.runner.resume(sweep, "berta")
        return self.wait(sweep)

    def wait(self, sweep: str) -> SweepStatus:
        assert self.runner.wait(BOUND_S), "the sweep goes on and on"
        return self.runner.status(sweep)

    def start_again(self) -> None:
        self.runner.close()
        self.lab.start_again()
        self._open()

    def close(self) -> None:
        self.runner.close()
        self.lab.close()

    def steps(self, sweep: str) -> list[StepRecord]:
        return self.lab.store.sweeps.steps(sweep)

    def states(self, sweep: str) -> list[str]:
        return [str(step.state) for step in self.steps(sweep)]

    @property
    def fires(self) -> int:
        return len(self.lab.trigger.fired)

    def at_fire(self, number: int, act: Callable[[], None]) -> None:
        """Do something just after a fire command has left, the first being 1."""

        def fired() -> None:
            if self.fires == number:
                act()

        self.lab.trigger.hooks["fire"] = fired

    def measure(self, shot: str, e: float, sigma: float) -> None:
        """Let a stored shot be analysed."""
        store = self.lab.store
        store.move(shot, ShotState.ANALYSING)
        result = {"status": "measured", "e": {"value": e, "sigma": sigma, "unit": "1"}}
        number = store.folders.add_result(shot, result)
        store.move(shot, ShotState.ANALYSED, Change(results=number))


def paused(status: SweepStatus) -> str:
    assert status.record.state is SweepState.PAUSED
    return status.record.reason
