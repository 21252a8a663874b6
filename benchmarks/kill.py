"""A daemon that is killed again and again while it sweeps: python -m benchmarks.kill.

Each life of the daemon is a process of its own on one store: it recovers, releases the rig as a
person would, goes on with its sweep, and is killed with SIGKILL at a random moment, some while they
still recover. Devices, wires and world are simulated, films are short. The world's own count of
fires, one line forced to disk for each, is the judge; what the daemon claimed before it died is
kept by the killer. Prints what was found and writes out/kill.json; ends 1 if anything was lost or
fired twice.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import random
import select
import signal
import sqlite3
import statistics
import sys
import tempfile
import time
import uuid
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING
from unittest import mock

import simulators.laboratory  # noqa: F401 - loaded once here instead of in every life
from rigctl.config import Configuration, load
from rigctl.store import ShotState, reading
from rigctl.store.integrity.verifying import verify_store
from rigctl.sweeps.form import Sweep
from rigctl.sweeps.plan import plan_of
from simulators.world.flight import load_integrator

if TYPE_CHECKING:
    from rigctl.daemon import Daemon

OUT = Path("out/kill.json")
WHILE_RECOVERING = 0.2
"""Share of the lives that are killed at any moment, ready or not."""
LONGEST_LIFE_S = 1.2
"""From a rig that takes orders to the kill; as long as the start took, where that took longer."""
READY_WITHIN_S = 120.0
RESTART_WITHIN_S = 5.0
FORM = Sweep.model_validate_json(
    '{"grid": {"pressure_a_kpa": [30, 40, 50, 60], "offset_mm": [2, 6, 10, 14]}, "campaign": "k"}'
)


@dataclass(slots=True)
class Findings:
    """What the killer found; everything but the counts of kills and shots should be nothing.

    Attributes
    ----------
    restart_s
        From the start of a life (modules loaded) to a rig that takes orders, s.
    never_ready
        The lives that were not ready in time; a host that is busy with other work starves some.
    fires, certain, possible
        What the world counted, and between which numbers it must lie by the word of the catalogue.
    """

    kills: int = 0
    shots: int = 0
    sweeps: int = 0
    unknown: int = 0
    fires: int = 0
    certain: int = 0
    possible: int = 0
    acknowledged: int = 0
    never_ready: list[int] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)
    damaged: list[str] = field(default_factory=list)
    fired_twice: list[str] = field(default_factory=list)
    restart_s: list[float] = field(default_factory=list)

    @property
    def sound(self) -> bool:
        """Whether nothing was lost, damaged or fired twice."""
        faults = (*self.never_ready, *self.lost, *self.damaged, *self.fired_twice)
        return not faults and self.certain <= self.fires <= self.possible

    @property
    def in_time(self) -> bool:
        """Whether restarts are: by their median, for the longest says more of a busy host."""
        return statistics.median(self.restart_s or [0.0]) < RESTART_WITHIN_S

    def summary(self) -> str:
        """Return the findings as lines of text."""
        restarts = self.restart_s or [0.0]
        return (
            f"{self.kills} kills, {self.sweeps} sweeps, {self.shots} shots, of which "
            f"{self.unknown} of unknown outcome\n"
            f"fires counted by the world: {self.fires}; by the catalogue {self.certain} to "
            f"{self.possible}; steps fired twice: {len(self.fired_twice)}\n"
            f"acknowledged: {self.acknowledged}; lost: {len(self.lost)}; damaged: "
            f"{len(self.damaged)}\n"
            f"restart: median {statistics.median(restarts):.2f} s, longest {max(restarts):.2f} s; "
            f"not within {READY_WITHIN_S:g} s: {len(self.never_ready)}"
        )


class NoAnalysis:
    """In the place of the analysis, which has no part in firing and takes seconds to load."""

    def __init__(self, *_: object, **__: object) -> None:
        pass

    def prepare(self) -> None:
        pass

    def submit(self, shot: str) -> None:
        pass

    def submit_by(self, shot: str, method: str) -> None:
        pass

    def cancel(self, shot: str) -> None:
        pass

    def awaited(self, _: str) -> None:
        """Return how a shot's analysis stands: none ever waits."""

    def close(self) -> None:
        pass


def configuration(folder: Path) -> Configuration:
    """Return the simulated rig with short films and quick devices."""
    document = load().model_dump(mode="json")
    document["store"]["folder"] = str(folder)
    document["simulation"] |= {
        "pressure_lag_s": 0.001,
        "slide_speed_mm_per_s": 5000.0,
        "run_up_s": 0.0,
    }
    document["camera"] |= {"frames_before_mark": 1, "frames_after_mark": 3}
    document["limits"]["cool_down_s"] = 0.0
    return Configuration.model_validate_json(json.dumps(document))


def live(chosen: Configuration, says: int) -> None:
    """Sweep until killed; tell through a pipe when ready, and each shot once it is on disk."""
    with _opened(chosen) as daemon:
        daemon.store.listeners.add(
            lambda shot: _say(says, shot.id) if shot.state is ShotState.STORED else None
        )
        _say(says, "ready")
        for offered in daemon.offered:
            _go_on(daemon, offered.id)
        while True:
            _go_on(daemon, None)


@contextlib.contextmanager
def _opened(chosen: Configuration) -> Iterator[Daemon]:
    # Loaded here: the library of the slide runs threads of its own, which no fork survives.
    from rigctl import daemon  # noqa: PLC0415

    with mock.patch.object(daemon, "Analyser", NoAnalysis), daemon.open_daemon(chosen) as opened:
        yield opened


def _go_on(daemon: Daemon, sweep: str | None) -> None:
    from rigctl.rig.states import LATCHED  # noqa: PLC0415

    if daemon.rig.status().state in LATCHED:
        daemon.rig.release("the killer", "looked at the tubes")
    if sweep is None:
        daemon.sweeps.start(plan_of(FORM), str(uuid.uuid4()), "", "the killer")
    else:
        daemon.sweeps.resume(sweep, "the killer")
    daemon.sweeps.wait(3600.0)


def _say(says: int, word: str) -> None:
    os.write(says, f"{word}\n".encode())


def kill_once(chosen: Configuration, chance: random.Random, found: Findings) -> list[str]:
    """Start a life, end it at a random moment, and return the shots it claimed to have stored."""
    hears, says = os.pipe()
    began = time.monotonic()
    child = os.fork()
    if child == 0:
        os.close(hears)
        with contextlib.suppress(BaseException):
            live(chosen, says)
        os._exit(1)
    os.close(says)
    try:
        heard = b""
        if chance.random() >= WHILE_RECOVERING:
            ready, _, _ = select.select([hears], [], [], READY_WITHIN_S)
            heard = os.read(hears, 65536) if ready else b""
            found.restart_s.append(time.monotonic() - began)
            if not heard:
                found.never_ready.append(found.kills)
        longest_s = max(LONGEST_LIFE_S, found.restart_s[-1] if heard else 0.0)
        time.sleep(chance.uniform(0.0, longest_s))
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    found.kills += 1
    while more := os.read(hears, 65536):
        heard += more
    os.close(hears)
    return [line for line in heard.decode().splitlines() if line != "ready"]


def audit(chosen: Configuration, folder: Path, claimed: list[str], found: Findings) -> None:
    """Recover once more, then compare the catalogue with the world's count and the claims."""
    with _opened(chosen) as daemon:
        daemon.store.journal.verify()
    fires = folder / "laboratory" / "truth" / "fires.jsonl"
    found.fires = len(fires.read_text().splitlines()) if fires.exists() else 0
    found.acknowledged = len(claimed)
    with _catalogue(folder) as catalogue:
        shots = catalogue.execute("SELECT id, state, fired FROM shots").fetchall()
        # The note of a shot that a sweep fired names sweep and step.
        flew = [
            note
            for (note,) in catalogue.execute(
                "SELECT note FROM shots WHERE fired != 'no' AND actor LIKE 'sweep %'"
            )
        ]
        found.sweeps = int(catalogue.execute("SELECT count(*) FROM sweeps").fetchone()[0])
    found.shots = len(shots)
    found.unknown = sum(fired == "unknown" for _, _, fired in shots)
    found.certain = sum(fired == "yes" for _, _, fired in shots)
    found.possible = found.certain + found.unknown
    found.fired_twice += sorted({step for step in flew if flew.count(step) > 1})
    stored = {name for name, state, _ in shots if state == "stored"}
    found.lost += [name for name in claimed if name not in stored]
    found.damaged += [name for name in sorted(stored) if not _whole(folder, name)]
    with reading(folder) as store:
        faults = verify_store(store, lambda _text, _share: None).faults
    found.damaged += [f"{fault.part} {fault.what}" for fault in faults]


@contextlib.contextmanager
def _catalogue(folder: Path) -> Iterator[sqlite3.Connection]:
    connection = sqlite3.connect(f"{(folder / 'catalogue.db').as_uri()}?mode=ro", uri=True)
    with contextlib.closing(connection):
        yield connection


def _whole(folder: Path, shot: str) -> bool:
    for place in folder.glob(f"shots/*/{shot}"):
        about = json.loads((place / "manifest.json").read_text())["frames"]
        digest = hashlib.sha256((place / "frames.npy").read_bytes()).hexdigest()
        return bool(digest == about["sha256"])
    return False


def main() -> int:
    """Kill as often, or for as long, as asked; print and write the findings."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--kills", type=int, default=1000)
    asked.add_argument("--seconds", type=float, default=float("inf"), help="kill no longer than so")
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--out", type=Path, default=OUT)
    options = asked.parse_args()
    load_integrator()
    chance, found = random.Random(options.seed), Findings()
    claimed: list[str] = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "data"
        chosen = configuration(folder)
        ends = time.monotonic() + options.seconds
        while found.kills < options.kills and time.monotonic() < ends:
            claimed += kill_once(chosen, chance, found)
        audit(chosen, folder, claimed, found)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(asdict(found) | {"sound": found.sound}, indent=1) + "\n")
    print(found.summary())
    return 0 if found.sound and found.in_time else 1


if __name__ == "__main__":
    sys.exit(main())
