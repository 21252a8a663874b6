"""A stop while the rig is being armed: the power goes, and what moved comes to rest."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rigctl.config import StoreSection, load
from rigctl.daemon import Daemon, open_daemon
from rigctl.errors import RigError
from rigctl.rig.standing import AFTER_STOP
from rigctl.settings import ShotSettings
from tests.simulated import patient, wait_long

FAR = ShotSettings(pressure_a_kpa=110.0, pressure_b_kpa=110.0, offset_mm=23.0)
SLOW_MM_PER_S = 1.0
"""On its way for 20 s: a stop finds the slide in motion on a busy machine too."""
LAG_S = 1.0


@pytest.fixture
def daemon(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Daemon]:
    wait_long(monkeypatch)
    configuration = load()
    assert configuration.simulation is not None
    slow = {"slide_speed_mm_per_s": SLOW_MM_PER_S, "pressure_lag_s": LAG_S}
    changes = {
        "store": StoreSection(folder=str(tmp_path / "data")),
        "simulation": configuration.simulation.model_copy(update=slow),
    }
    with open_daemon(patient(configuration.model_copy(update=changes))) as opened:
        yield opened


def until(condition: Callable[[], bool]) -> None:
    """Return once the condition holds; fail after a minute."""
    deadline = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.002)


def test_a_stop_during_arming_halts_slide_and_pressure_and_says_so(daemon: Daemon) -> None:
    laboratory: Any = daemon.laboratory
    refused: list[RigError] = []

    def arm() -> None:
        with pytest.raises(RigError) as caught:
            daemon.rig.arm(FAR, "anna")
        refused.append(caught.value)

    rest = laboratory.state()["offset_mm"]
    arming = threading.Thread(target=arm)
    arming.start()
    # It has found its home, which is the other way, and is on its way to the set point.
    until(lambda: laboratory.state()["offset_mm"] > rest + 0.5)
    daemon.rig.estop("berta", "a hand in the tube")
    assert laboratory.state()["powered"] is False
    arming.join(60.0)
    assert not arming.is_alive()
    assert len(refused) == 1

    def after_stop() -> list[str]:
        entries = daemon.store.journal.entries(limit=100)
        return [entry.reason for entry in entries if entry.actor == AFTER_STOP]

    until(lambda: bool(after_stop()))
    assert "slide (zaber): stopped" in after_stop()[0]
    assert "regulator (alicat): set to 0 kPa" in after_stop()[0]
    assert "trigger (trigger-box): safe" in after_stop()[0]
    stands = laboratory.state()["offset_mm"]
    until(lambda: laboratory.state()["pressure_a_kpa"] < 1.0)
    until(lambda: laboratory.state()["pressure_b_kpa"] < 1.0)
    assert laboratory.state()["offset_mm"] == stands < 20.0
