"""A run engine in front of a daemon with the simulated laboratory: it counts the fires itself."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("bluesky")

import event_model
from bluesky import RunEngine
from bluesky.utils import RunEngineInterrupted

from rigctl.bluesky_devices import Rig, fire_once
from rigctl.client import connected
from rigctl.settings import ShotSettings

pytestmark = pytest.mark.long

SETTINGS = ShotSettings(pressure_a_kpa=60, pressure_b_kpa=60, offset_mm=6)
WAIT_S = 60.0


@pytest.fixture
def daemon(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Run a daemon of its own; give the folder it runs in."""
    environment = {name: value for name, value in os.environ.items() if name != "RIGCTL_KEY"}
    monkeypatch.delenv("RIGCTL_KEY", raising=False)
    monkeypatch.chdir(tmp_path)
    process = subprocess.Popen(
        [str(Path(sys.executable).with_name("rigctl")), "serve", "--port", "0"],
        cwd=tmp_path,
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        assert "?key=" in process.stdout.readline()
        yield tmp_path
    finally:
        process.terminate()
        process.communicate(timeout=WAIT_S)


@pytest.fixture
def engine() -> Iterator[RunEngine]:
    running = RunEngine({}, context_managers=[])
    yield running
    running.loop.call_soon_threadsafe(running.loop.stop)
    running._th.join(WAIT_S)
    running.loop.close()


def fires(folder: Path) -> int:
    """Return how often the laboratory fired, by its own count."""
    file = folder / "data/laboratory/truth/fires.jsonl"
    return len(file.read_text().splitlines()) if file.exists() else 0


def test_a_shot_fired_by_a_plan_is_measured_and_recorded(daemon: Path, engine: RunEngine) -> None:
    documents: list[tuple[str, dict[str, Any]]] = []
    with connected(None, None) as client:
        rig = Rig(client, campaign="nylon")
        engine(fire_once(rig, SETTINGS), lambda kind, one: documents.append((kind, one)))
    assert fires(daemon) == 1
    for kind, document in documents:
        event_model.schema_validators[event_model.DocumentNames[kind]].validate(document)
    event = next(document for kind, document in documents if kind == "event")
    assert event["data"]["rig_state"] == "analysed"
    assert 0.5 < event["data"]["rig_e"] < 1
    assert event["data"]["rig_pressure_a_kpa"] == 60


def test_a_run_that_is_paused_in_its_shot_has_fired_once_and_cannot_go_on(
    daemon: Path, engine: RunEngine
) -> None:
    paused: list[str] = []

    class Hasty(Rig):
        """Asks for a pause right after the first fire."""

        def _fired_once(self) -> str:
            shot = super()._fired_once()
            if not paused:
                paused.append(shot)
                engine.request_pause(defer=False)
            return shot

    with connected(None, None) as client:
        rig = Hasty(client)
        with pytest.raises(RunEngineInterrupted):
            engine(fire_once(rig, SETTINGS))
        assert engine.state == "idle"
        # A fresh plan is a fresh shot; the device awaits the end of the one before.
        engine(fire_once(rig, SETTINGS))
    assert fires(daemon) == 2
