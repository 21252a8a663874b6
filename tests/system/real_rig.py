"""A real rig as the daemon sees one: a laboratory in a process of its own, on real ports."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx

from tests.invoked import Invoked, rigctl
from tests.plain_http import REQUESTS, lives

KEY = "the-key-of-a-real-rig"
RIGCTL = [sys.executable, "-c", "from rigctl.cli import main; main()"]
SHIFTED = """
import datetime, pathlib
from rigctl.rig.clock import SYSTEM_CLOCK
shift = pathlib.Path("clock-shift-s")
def wall():
    late = float(shift.read_text()) if shift.exists() else 0.0
    return datetime.datetime.now(datetime.UTC) + datetime.timedelta(seconds=late)
object.__setattr__(SYSTEM_CLOCK, "wall", wall)
from rigctl.cli import main
main()
"""
"""A daemon on a host whose wall clock a file sets: the test's own clock must not be moved."""
WAIT_S = 60.0
ROLES = ("trigger", "regulator", "slide", "cut-off", "recorder", "capture")
SIMULATED = Path(__file__).parents[2] / "config" / "simulated.toml"


def until(condition: Callable[[], bool], wait_s: float = 60.0) -> None:
    deadline = time.monotonic() + wait_s
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.01)


@dataclass
class RealRig:
    """A daemon without the table [simulation], and the hands at its laboratory."""

    folder: Path
    control: str
    url: str = ""
    process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        written = self.folder / "data" / "service.json"
        written.unlink(missing_ok=True)
        with (self.folder / "serve.log").open("a") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-c", SHIFTED, "serve", "--config", "rig.toml", "--port", "0"],
                cwd=self.folder,
                env={**os.environ, "RIGCTL_KEY": KEY},
                stdout=log,
                stderr=log,
            )
        until(lambda: self._ended() or (written.exists() and self._lives(written)), WAIT_S)
        assert not self._ended(), (self.folder / "serve.log").read_text()

    def end(self) -> None:
        assert self.process is not None
        self.process.terminate()
        self.process.wait(WAIT_S)

    def kill(self) -> None:
        assert self.process is not None
        self.process.kill()
        self.process.wait(WAIT_S)

    def ask(self, method: str, path: str, body: Any = None) -> httpx.Response:
        return REQUESTS.request(
            method,
            f"{self.url}/api/v1{path}",
            json=body,
            headers={"Authorization": f"Bearer {KEY}"},
            timeout=WAIT_S,
        )

    def command(self, *words: str, typed: str = "") -> Invoked:
        return rigctl(*words, "--config", "rig.toml", folder=self.folder, key=KEY, typed=typed)

    def second_daemon(self, config: str) -> subprocess.CompletedProcess[str]:
        """Try to serve the same rig once more, as a process, by another configuration."""
        return subprocess.run(
            [*RIGCTL, "serve", "--port", "0", "--config", config],
            cwd=self.folder,
            env={**os.environ, "RIGCTL_KEY": KEY},
            capture_output=True,
            text=True,
            timeout=WAIT_S,
            check=False,
        )

    def hand(self, **request: object) -> dict[str, Any]:
        """Do something in the laboratory: a fault, `clear`, `state`."""
        with socket.socket(socket.AF_UNIX) as link:
            link.connect(self.control)
            link.sendall(json.dumps(request).encode() + b"\n")
            return dict(json.loads(link.makefile().readline()))

    def fault(self, device: str, kind: str) -> None:
        assert self.hand(fault={"device": device, "kind": kind}) == {"ok": True}

    def set_clock(self, shift_s: float) -> None:
        """Set the wall clock of the daemon's host ahead."""
        (self.folder / "clock-shift-s").write_text(str(shift_s))

    def state(self) -> dict[str, Any]:
        return dict(self.hand(state=True)["state"])

    def edit(self, old: str, new: str) -> None:
        path = self.folder / "rig.toml"
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))

    def _ended(self) -> bool:
        return self.process is not None and self.process.poll() is not None

    def _lives(self, written: Path) -> bool:
        try:
            self.url = str(json.loads(written.read_text())["url"])
        except (OSError, ValueError):
            return False
        return lives(self.url)


@contextmanager
def real_rig(folder: Path) -> Iterator[RealRig]:
    """Start a laboratory and write the configuration of a real rig on its ports; starts none."""
    laboratory = subprocess.Popen(
        [sys.executable, "-m", "simulators", str(folder / "laboratory")], stdout=subprocess.PIPE
    )
    assert laboratory.stdout is not None
    paths = json.loads(laboratory.stdout.readline())
    (folder / "rig.toml").write_text(_configuration(folder, paths))
    rig = RealRig(folder, paths["control"])
    try:
        yield rig
    finally:
        if rig.process is not None:
            rig.kill()
        laboratory.terminate()
        laboratory.communicate(timeout=WAIT_S)


def _configuration(folder: Path, paths: dict[str, str]) -> str:
    before, _, after = SIMULATED.read_text().partition("[simulation]")
    text = before + after[after.index("[limits]") :]
    # The tape is started by the link: no process but the laboratory's own reaches its contact.
    contact = text.index("[camera.remote_trigger]")
    text = text[:contact] + text[text.index("[camera.recorder]") :]
    # What watches the daemon would stop the rig on a host that is busy with other tests.
    text = text.replace("[cut_off]", "[cut_off]\ndead_man = false #")
    text = text.replace("pulse_us = 20000", "pulse_us = 20000\nheartbeat = false")
    text = text.replace("answer_timeout_s = 0.5", "answer_timeout_s = 5.0")
    for role in ROLES:
        text = text.replace(f'"sim:{role}"', f'"{paths[role]}"')
    return text.replace('folder = "data"', f'folder = "{folder / "data"}"')
