"""The systemd unit against the daemon: what the one promises is what the other does."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest

from rigctl.cli.rig.serve import ANSWERS_WITHIN_S, END_WITHIN_S
from rigctl.config import load
from rigctl.config.loading import default_path
from rigctl.rig.machine import longest_run_s
from rigctl.rig.stopping.dead_man import CUT_WITHIN_S, SILENT_S
from rigctl.service.guards.connections import MOST_CONNECTIONS, SPARE_DESCRIPTORS

ROOT = Path(__file__).parents[2]
UNIT = ROOT / "packaging" / "rigctl.service"
ANALYZE = shutil.which("systemd-analyze")
WAIT_S = 60.0
EXPOSURE = 40
"""Tenths; systemd calls a unit below 4.5 well protected, and one without settings 9.6."""


def settings() -> dict[str, list[str]]:
    """Read the unit: the values of each setting, in order."""
    found: dict[str, list[str]] = {}
    for line in UNIT.read_text().splitlines():
        if line and line[0] not in "#;[":
            name, _, value = line.partition("=")
            found.setdefault(name, []).append(value)
    return found


SET = settings()


def one(name: str) -> str:
    (value,) = SET[name]
    return value


@dataclass
class Manager:
    """A service manager's end of the socket, which learns who speaks."""

    link: socket.socket
    path: str

    def heard(self) -> tuple[str, int]:
        """Return the next word and the process that sent it (sd_notify(3), unix(7))."""
        said, extra, _, _ = self.link.recvmsg(256, socket.CMSG_SPACE(12))
        ((_, _, credentials),) = extra
        return said.decode(), struct.unpack("3i", credentials)[0]


@pytest.fixture
def manager(tmp_path: Path) -> Iterator[Manager]:
    path = str(tmp_path / "notify")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as link:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 1)
        link.bind(path)
        link.settimeout(WAIT_S)
        yield Manager(link, path)


def started(folder: Path, manager: Manager, period_s: float) -> subprocess.Popen[bytes]:
    """Start the daemon by the unit's own command line, on a simulated rig with a long film."""
    program, *words = one("ExecStart").split()
    assert program.endswith("/bin/rigctl")
    text = default_path().read_text().replace("frames_after_mark = 120", "frames_after_mark = 1500")
    (folder / "rig.toml").write_text(text)
    place = words.index("--config") + 1
    words[place] = str(folder / "rig.toml")
    told = {"NOTIFY_SOCKET": manager.path, "WATCHDOG_USEC": str(round(1e6 * period_s))}
    return subprocess.Popen(
        [sys.executable, "-c", "from rigctl.cli import main; main()", *words, "--port", "0"],
        cwd=folder,
        env={**os.environ, "RIGCTL_KEY": "", **told},
        umask=int(one("UMask"), 8),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def fire(folder: Path) -> None:
    """Have a shot fired, and do not wait for its end."""
    at = json.loads((folder / "data" / "service.json").read_text())
    headers = {"Authorization": f"Bearer {at['key']}"}
    order = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": 6.0}
    with httpx.Client(base_url=f"{at['url']}/api/v1", headers=headers, timeout=WAIT_S) as client:
        armed = client.post("/rig/arm", json=order)
        assert armed.is_success, armed.text
        token = {"arm_token": armed.json()["arm_token"]}
        fired = client.post("/shots", json=token, headers={"Idempotency-Key": "one"})
        assert fired.status_code == 202, fired.text


def test_the_daemon_tells_the_manager_of_its_start_its_life_and_its_end(
    tmp_path: Path, manager: Manager
) -> None:
    assert (one("Type"), "NotifyAccess" in SET) == ("notify", False)
    with started(tmp_path, manager, period_s=0.3) as daemon:
        try:
            assert manager.heard() == ("READY=1", daemon.pid)
            assert [manager.heard() for _ in range(2)] == [("WATCHDOG=1", daemon.pid)] * 2
            fire(tmp_path)
            daemon.send_signal(getattr(signal, SET.get("KillSignal", ["SIGTERM"])[0]))
            while (said := manager.heard()) != ("STOPPING=1", daemon.pid):
                assert said == ("WATCHDOG=1", daemon.pid)
            # The film of the shot under way takes 1.5 s: who falls silent meanwhile is killed.
            for _ in range(5):
                assert manager.heard() == ("WATCHDOG=1", daemon.pid)
            assert daemon.wait(WAIT_S) == 0
        finally:
            daemon.kill()


def seconds(name: str) -> float:
    return float(one(name))


def test_the_times_of_the_unit_leave_the_daemon_its_own() -> None:
    # A sign of life is due every third of the time, and the questions before it take theirs.
    assert seconds("WatchdogSec") / 3 + ANSWERS_WITHIN_S + SILENT_S < seconds("WatchdogSec")
    assert seconds("WatchdogSec") > SILENT_S
    for name in ("simulated", "pusher", "release"):
        longest_s = longest_run_s(load(ROOT / "config" / f"{name}.toml").camera)
        assert longest_s + END_WITHIN_S < seconds("TimeoutStopSec"), name


def test_the_daemon_alone_is_killed_and_its_dead_man_lives_to_cut() -> None:
    assert (one("KillMode"), one("WatchdogSignal"), one("Restart")) == (
        "process",
        "SIGKILL",
        "on-failure",
    )
    assert CUT_WITHIN_S > SILENT_S


def test_the_unit_leaves_room_for_connections_and_what_jobs_need() -> None:
    assert int(one("LimitNOFILE")) >= MOST_CONNECTIONS + 2 * SPARE_DESCRIPTORS
    assert one("WorkingDirectory") == f"/var/lib/{one('StateDirectory')}"
    assert (one("StateDirectoryMode"), one("UMask")) == ("0700", "0077")
    # `jobs.enclosure` unshares user, mount and network namespaces.
    assert set(one("RestrictNamespaces").split()) == {"user", "mnt", "net"}
    # Machine code is compiled at run time.
    assert "MemoryDenyWriteExecute" not in SET


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """Give the unit with a program that is there."""
    unit = tmp_path / UNIT.name
    unit.write_text(re.sub(r"ExecStart=\S+", f"ExecStart={sys.executable}", UNIT.read_text()))
    return unit


@pytest.mark.skipif(ANALYZE is None, reason="systemd is not installed")
@pytest.mark.parametrize(
    "words", [("verify",), ("security", "--offline=true", f"--threshold={EXPOSURE}")]
)
def test_systemd_finds_nothing_wrong_with_the_unit(installed: Path, words: tuple[str, ...]) -> None:
    done = subprocess.run(
        [str(ANALYZE), *words, "--no-pager", str(installed)],
        capture_output=True,
        text=True,
        timeout=WAIT_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert UNIT.name not in done.stderr
