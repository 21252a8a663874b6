"""The default rig as tests take it: with films that show no spheres, or with patience."""

from __future__ import annotations

import json
import re
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from rigctl.config import Configuration, StoreSection, load

FRAMES_AFTER_MARK = 15
"""Spheres come into the picture some 50 ms after the fire."""

LONGEST_S = {
    "answer_timeout_s": 20.0,
    "start_timeout_s": 20.0,
    "collect_timeout_s": 120.0,
    "settle_timeout_s": 120.0,
}
"""Longest waits for devices on a machine that is busy with something else."""

WAITS = {
    "rigctl.rig.stopping.estop": ("LINE_WAIT_S", "REST_WAIT_S", "WITNESS_WAIT_S"),
    "rigctl.rig.standing": ("NOTE_WAIT_S",),
    "rigctl.rig.machine": ("_DEVICES_WAIT_S",),
    "rigctl.sweeps.runner": ("PAUSE_WAIT_S",),
}
"""Longest waits of the daemon for its own threads and lines, by module."""


def with_short_films(folder: Path | str) -> Configuration:
    """Return the default configuration with a store in a folder and films of 15 ms."""
    usual = load()
    camera = usual.camera.model_copy(update={"frames_after_mark": FRAMES_AFTER_MARK})
    return usual.model_copy(update={"store": StoreSection(folder=str(folder)), "camera": camera})


def patient(configuration: Configuration) -> Configuration:
    """Return the configuration with all waits for devices as long as a busy machine needs."""

    def longer(section: Any) -> Any:
        if not isinstance(section, dict):
            return section
        return {key: LONGEST_S.get(key, longer(value)) for key, value in section.items()}

    document = longer(configuration.model_dump(mode="json"))
    return Configuration.model_validate_json(json.dumps(document))


def patient_text(configuration: str) -> str:
    """Return the text of a configuration that waits for devices as long as a busy machine needs."""
    names = "|".join(LONGEST_S)
    changed, count = re.subn(
        rf"^({names}) = .*",
        lambda found: f"{found[1]} = {LONGEST_S[found[1]]}",
        configuration,
        flags=re.MULTILINE,
    )
    assert count
    return changed


def wait_long(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no wait of the daemon, in this process, run out because the machine is busy."""
    for module, names in WAITS.items():
        if (loaded := sys.modules.get(module)) is not None:
            for name in names:
                monkeypatch.setattr(loaded, name, 60.0)


class LaboratoryClock:
    """Time of a simulated laboratory, s, which can be stopped while other threads are slow."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._lost_s = 0.0
        self._stopped_at_s: float | None = None

    def __call__(self) -> float:
        with self._lock:
            return self._running() if self._stopped_at_s is None else self._stopped_at_s

    @contextmanager
    def stopped(self) -> Iterator[None]:
        """Let all that happens in a `with` block happen at one moment."""
        with self._lock:
            self._stopped_at_s = self._running()
        try:
            yield
        finally:
            with self._lock:
                assert self._stopped_at_s is not None
                self._lost_s = time.monotonic() - self._stopped_at_s
                self._stopped_at_s = None

    def _running(self) -> float:
        return time.monotonic() - self._lost_s
