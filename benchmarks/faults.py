"""Every fault in every state: python -m benchmarks.faults.

The plan is generated: each state that a shot passes in the rig's transition table, by each fault
of each simulated device, of the disk, the catalogue and the clock, and of the worker that analyses
an earlier shot meanwhile. A fault strikes when the rig enters the state, while one shot is armed
and fired; states that a shot passes only when something fails are provoked. Then it must hold that

- whatever was raised is an error of rigctl, with a code;
- the rig has come to rest: idle, or waiting for a person;
- the record agrees with the world's own count of fires, and nothing fired twice;
- no shot is left without an end, and one whose worker was killed says so;
- once the fault is gone, and the rig released where it waits, the next shot is stored, without a
  restart.

Prints the faults tried and survived, and each that was not; ends 1 if there is one.
"""

from __future__ import annotations

import argparse
import contextlib
import errno
import json
import random
import sqlite3
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from datetime import datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

from benchmarks import killed_worker
from benchmarks.kill import configuration
from rigctl import daemon as daemons
from rigctl.config import Configuration
from rigctl.daemon import Daemon
from rigctl.errors import RigError
from rigctl.rig.clock import SYSTEM_CLOCK, Clock
from rigctl.rig.machine import Rig
from rigctl.rig.states import LATCHED, TRANSITIONS, RigState
from rigctl.rig.status import Transition
from rigctl.settings import ShotSettings
from rigctl.store import Fired, ShotRecord
from rigctl.store.states import RUNNING
from simulators.ektapro.faults import FrameFault
from simulators.wire.faults import SerialFault
from simulators.wire.hid_relay import UsbFault
from simulators.world.flight import load_integrator

OUT = Path("out/faults.json")
SETTINGS = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0)
RESTS_WITHIN_S = 60.0
PASSED = tuple(state for state in RigState if state in TRANSITIONS and state not in LATCHED)
"""States that a shot may pass; a person ends the others."""
RESTS = LATCHED | {RigState.IDLE}
SERIAL = ("trigger", "regulator", "slide", "cut-off", "recorder")
WRITES = (
    "rigctl.store.folders.write_synced",
    "rigctl.store.folders.write_over_synced",
    "rigctl.store.durable.os.posix_fallocate",
    "rigctl.rig.stopping.latch.write_synced",
)
"""What the daemon writes a shot and a latch by."""
PROVOKED: dict[RigState, tuple[str, str, dict[str, Any]]] = {
    RigState.ABORTED: ("recorder", "never-starts", {}),
    RigState.MISFIRE: ("trigger", "deaf", {"command": "FIRE"}),
}
"""The fault, of which device, by which a shot comes to a state that it does not pass unharmed."""
CATALOGUE_BUSY_S = 0.1
CLOCK_STEP_S = 3600.0


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault: of which part, of which kind, striking when the rig enters a state."""

    part: str
    kind: str
    state: RigState

    def __str__(self) -> str:
        return f"{self.part} {self.kind} when {self.state}"


@dataclass(slots=True)
class Findings:
    """What became of the faults: errors by code, and what did not hold."""

    tried: int = 0
    struck: int = 0
    ends: dict[str, int] = field(default_factory=dict)
    states: dict[str, int] = field(default_factory=dict)
    failed: list[str] = field(default_factory=list)


class Bench:
    """One daemon over a simulated laboratory, with a clock that can be stepped."""

    def __init__(self, opened: Daemon, folder: Path) -> None:
        self.daemon, self.folder = opened, folder
        self.laboratory: Any = opened.laboratory
        self.step_s = 0.0
        self.keys = 0
        self._ends: list[Callable[[], None]] = []

    def strike(self, fault: Fault) -> None:
        """Make a fault happen now."""
        if fault.part == "disk":
            # The laboratory shares this process: only what the daemon writes meets a full disk.
            for place in WRITES:
                full = mock.patch(place, side_effect=OSError(errno.ENOSPC, "No space left"))
                full.start()
                self._ends.append(full.stop)
        if fault.part == "catalogue" or fault.kind == "takes nothing":
            self._lock_catalogue()
        elif fault.part == "worker":
            killed_worker.kill()
        elif fault.part == "clock":
            self.step_s = CLOCK_STEP_S if fault.kind == "forward" else -CLOCK_STEP_S
        elif fault.part != "disk":
            self.laboratory.fault(fault.part, fault.kind)

    def _lock_catalogue(self) -> None:
        other = sqlite3.connect(
            self.folder / "catalogue.db", timeout=CATALOGUE_BUSY_S, check_same_thread=False
        )
        self._ends.append(other.close)
        with contextlib.suppress(sqlite3.OperationalError):
            other.execute("BEGIN IMMEDIATE")

    def mend(self) -> None:
        """Take every fault away."""
        while self._ends:
            self._ends.pop()()
        self.step_s = 0.0
        self.laboratory.clear_faults()

    def shoot(self) -> ShotRecord:
        """Arm and fire once, under a key of its own."""
        self.keys += 1
        rig = self.daemon.rig
        token = rig.arm(SETTINGS, "the bench").token
        return rig.fire(token, f"key {self.keys} {time.monotonic_ns()}", "body", actor="the bench")

    def rest(self) -> RigState:
        """Wait until the rig has come to rest, and return its state."""
        ends = time.monotonic() + RESTS_WITHIN_S
        while time.monotonic() < ends:
            status = self.daemon.rig.status()
            if status.running is None and (
                status.state is RigState.IDLE or status.state in LATCHED
            ):
                return status.state
            if status.state is RigState.ARMED:
                self.daemon.rig.disarm("the bench", "the token was not used")
            time.sleep(0.005)
        return self.daemon.rig.status().state

    def recover(self) -> None:
        """Release the rig where it waits for a person, as soon as it lets itself be released."""
        ends = time.monotonic() + RESTS_WITHIN_S
        while self.daemon.rig.status().state in LATCHED:
            try:
                self.daemon.rig.release("the bench", "mended")
            except RigError:
                if time.monotonic() > ends:
                    raise
                time.sleep(0.05)


def plan() -> list[Fault]:
    """Return every fault in every state, in order."""
    faults = [(part, kind) for part in SERIAL for kind in (*SerialFault, "unplug")]
    faults += [(part, "stuck") for part in ("trigger", "regulator", "slide", "cut-off")]
    faults += [("recorder", "never-starts")]
    faults += [("recorder", kind) for kind in FrameFault]
    faults += [("relay", kind) for kind in (*UsbFault, "stuck")]
    faults += [("disk", "takes nothing"), ("disk", "takes no frames"), ("catalogue", "locked")]
    faults += [("clock", "forward"), ("clock", "back"), ("worker", "killed")]
    return [Fault(part, str(kind), state) for state in PASSED for part, kind in faults]


def attempt(bench: Bench, fault: Fault, found: Findings) -> None:
    """Let one fault strike a shot, and see what holds afterwards."""
    held = ""
    if fault.part == "worker":
        held = bench.shoot().id
        killed_worker.hold(bench.daemon, held)
    fires_before = bench.laboratory.fires
    struck = [False]

    def enters(step: Transition) -> None:
        if step.after is fault.state and not struck[0]:
            struck[0] = True
            bench.strike(fault)

    if fault.state is RigState.IDLE:
        bench.strike(fault)
        struck[0] = True
    if fault.state in PROVOKED:
        part, kind, options = PROVOKED[fault.state]
        bench.laboratory.fault(part, kind, **options)
    deaf = bench.daemon.rig.listeners.add(enters)
    error: Exception | None = None
    end = ""
    try:
        shot = bench.shoot()
        end = f"shot {shot.outcome}" + (f", {shot.failure_code}" if shot.failure_code else "")
    except Exception as raised:  # noqa: BLE001 - what should not be raised is what is looked for
        error = raised
        end = f"refused, {getattr(raised, 'code', type(raised).__name__)}"
    state = bench.rest()
    deaf()
    found.tried += 1
    found.struck += struck[0]
    found.ends[end] = found.ends.get(end, 0) + 1
    found.states[state] = found.states.get(state, 0) + 1
    bench.mend()
    for complaint in complaints(bench, error, state, fires_before):
        found.failed.append(f"{fault}: {complaint}")
    if held and (last := bench.daemon.store.catalogue.last()) is not None:
        # One that was not struck is killed now: nothing may be left to the next fault.
        killed_worker.kill()
        for complaint in killed_worker.complaints(bench.daemon, held, last.id):
            found.failed.append(f"{fault}: {complaint}")


def complaints(
    bench: Bench, error: Exception | None, state: RigState, fires_before: int
) -> Iterator[str]:
    """Yield what does not hold after a fault."""
    if error is not None and not isinstance(error, RigError):
        yield f"raised {error!r}, which is no error of rigctl"
    if state not in RESTS:
        yield f"the rig stays {state}"
    flew = bench.laboratory.fires - fires_before
    if flew > 1:
        yield f"fired {flew} times"
    last = bench.daemon.store.catalogue.last()
    if last is not None and flew == 1 and last.fired is Fired.NO:
        yield "fired, and its record says no"
    try:
        bench.recover()
        # The first shot after a fault may be refused once: a line that was lost is opened by it.
        try:
            shot = bench.shoot()
        except RigError:
            bench.recover()
            shot = bench.shoot()
        if shot.outcome != "stored":
            yield f"the next shot is {shot.outcome}: {shot.failure}"
    except RigError as raised:
        yield f"the next shot does not work: {raised}"
    bench.recover()
    for shot in bench.daemon.store.catalogue.in_states(RUNNING):
        yield f"shot {shot.id} is left {shot.state}"


@contextlib.contextmanager
def opened(folder: Path, answer_timeout_s: float = 1.0) -> Iterator[Bench]:
    """Open a daemon with short films, quick devices and a clock to be stepped."""
    document = configuration(folder).model_dump(mode="json")
    for section in ("trigger", "regulator", "slide"):
        document[section]["answer_timeout_s"] = answer_timeout_s
    document["camera"] |= {"start_timeout_s": 5.0, "collect_timeout_s": 15.0}
    document["camera"]["recorder"]["answer_timeout_s"] = answer_timeout_s
    document["limits"] |= {"settle_timeout_s": 1.5, "free_disk_mb": 1.0}
    bench: list[Bench] = []

    def wall() -> datetime:
        return SYSTEM_CLOCK.wall() + timedelta(seconds=bench[0].step_s if bench else 0.0)

    clock = Clock(SYSTEM_CLOCK.monotonic, wall, SYSTEM_CLOCK.wait)
    strict = Configuration.model_validate_json(json.dumps(document))
    load_integrator()
    with (
        mock.patch.object(daemons, "Analyser", killed_worker.ByRequest),
        mock.patch.object(daemons, "Rig", partial(Rig, clock=clock)),
        daemons.open_daemon(strict) as daemon,
    ):
        bench.append(Bench(daemon, folder))
        yield bench[0]


def main() -> int:
    """Try the plan, or a part of it drawn by chance; print and write the findings."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--most", type=int, default=0, help="so many, drawn by chance; 0: all")
    asked.add_argument("--part", help="faults of this part alone, worker for one")
    asked.add_argument("--share", type=float, default=1.0, help="of the plan, drawn by chance")
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--out", type=Path, default=OUT)
    options = asked.parse_args()
    chosen = [fault for fault in plan() if options.part in {None, fault.part}]
    found = Findings()
    most = options.most or round(options.share * len(chosen))
    if most < len(chosen):
        chosen = random.Random(options.seed).sample(chosen, most)
    with tempfile.TemporaryDirectory() as temporary, opened(Path(temporary) / "data") as bench:
        for fault in chosen:
            before = len(found.failed)
            attempt(bench, fault, found)
            for complaint in found.failed[before:]:
                print(complaint, flush=True)
    survived = found.tried - len({text.partition(":")[0] for text in found.failed})
    print(f"{found.tried} faults tried, {found.struck} struck, {survived} survived")
    for name, counts in (("ended", found.ends), ("came to rest", found.states)):
        listed = sorted(counts.items(), key=lambda pair: -pair[1])
        print(f"{name}: " + "; ".join(f"{what} {count}" for what, count in listed))
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(asdict(found), indent=1) + "\n")
    return 1 if found.failed else 0


if __name__ == "__main__":
    sys.exit(main())
