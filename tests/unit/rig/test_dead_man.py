"""The dead man: its process cuts at the relay when the heartbeat stops, and only then."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest
from rig_fakes import BOUND_S, FakeCutOff, FakeTrigger, Laboratory, until

from rigctl.config import Configuration, load
from rigctl.daemon import _watches
from rigctl.devices.roles import Actuators
from rigctl.errors import DeviceError
from rigctl.rig.stopping import dead_man
from rigctl.rig.stopping.dead_man import DeadMan

CUT = bytes.fromhex("a0 01 00 a1")


@dataclass
class Relay:
    """The far end of a serial line on which a relay would listen."""

    master: int
    path: str

    def heard(self, within_s: float = BOUND_S) -> bytes:
        ready, _, _ = select.select([self.master], [], [], within_s)
        return os.read(self.master, 64) if ready else b""


@pytest.fixture
def relay() -> Iterator[Relay]:
    master, slave = pty.openpty()
    yield Relay(master, os.ttyname(slave))
    os.close(master)
    os.close(slave)


@pytest.fixture
def watching(relay: Relay) -> Iterator[DeadMan]:
    """Watch over a silence that no busy machine makes by itself."""
    found = DeadMan(relay.path, 1, silent_s=10 * BOUND_S)
    yield found
    found.end()


def test_a_heartbeat_that_stops_is_followed_by_the_cut_and_told(relay: Relay) -> None:
    watching = DeadMan(relay.path, 1)
    told: list[str] = []
    tripped = threading.Event()

    def note(why: str) -> None:
        told.append(why)
        tripped.set()

    watching.start(lambda: False, note)
    assert relay.heard() == CUT
    assert tripped.wait(BOUND_S)
    assert "cut the power" in told[0]
    assert not watching.watches
    watching.end()


def test_the_end_of_the_process_that_was_watched_is_followed_by_the_cut(relay: Relay) -> None:
    script = (
        "import sys, time; from rigctl.rig.stopping.dead_man import DeadMan; "
        "DeadMan(sys.argv[1], 1).start(lambda: True, print); print('on', flush=True); "
        "time.sleep(100)"
    )
    with subprocess.Popen([sys.executable, "-c", script, relay.path], stdout=-1) as watched:
        assert watched.stdout is not None
        assert watched.stdout.readline() == b"on\n"
        watched.send_signal(signal.SIGKILL)
        assert relay.heard() == CUT


def test_heartbeats_and_an_orderly_end_cut_nothing(relay: Relay, watching: DeadMan) -> None:
    asked: list[None] = []

    def alive() -> bool:
        asked.append(None)
        return True

    watching.start(alive, pytest.fail)
    until(lambda: len(asked) >= 3)
    watching.end()
    assert relay.heard(0.1) == b""


@pytest.mark.parametrize(("last", "cuts"), [(b"e", []), (b"", ["relay"]), (None, ["relay"])])
def test_each_heartbeat_begins_the_silence_anew(
    monkeypatch: pytest.MonkeyPatch, last: bytes | None, cuts: list[str]
) -> None:
    heard, waited, cut = [b".", b"..", b".", last], list[float](), list[str]()

    def ready(*asked: object) -> tuple[list[int], list[int], list[int]]:
        waited.append(float(str(asked[-1])))
        return ([] if heard[0] is None else [0]), [], []

    def note(port: str, channel: int) -> bool:
        cut.append(port)
        return True

    line = SimpleNamespace(fileno=lambda: 0)
    acts = SimpleNamespace(write=lambda *_: 1, read=lambda *_: heard.pop(0))
    monkeypatch.setattr(dead_man, "signal", MagicMock())
    monkeypatch.setattr(dead_man, "os", acts)
    monkeypatch.setattr(dead_man, "select", SimpleNamespace(select=ready))
    monkeypatch.setattr(dead_man, "sys", SimpleNamespace(stdin=line, stdout=line))
    monkeypatch.setattr(dead_man, "cut", note)
    assert dead_man.watch("relay", 1, 0.6) == 0
    assert (cut, waited) == (cuts, [0.6] * 4)


def test_signals_to_all_processes_of_the_daemon_do_not_end_it(
    relay: Relay, watching: DeadMan
) -> None:
    watching.start(lambda: True, pytest.fail)
    process = watching._process
    assert process is not None
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        process.send_signal(number)
    assert relay.heard(0.3) == b""
    assert watching.watches


def test_a_relay_that_comes_back_late_is_cut_then(tmp_path: Path, relay: Relay) -> None:
    name = tmp_path / "relay"
    late = DeadMan(str(name), 1)
    told = threading.Event()
    late.start(lambda: False, lambda _: told.set())
    assert relay.heard(0.2) == b""
    name.symlink_to(relay.path)
    assert relay.heard() == CUT
    assert told.wait(BOUND_S)
    late.end()


def test_power_is_not_given_without_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lab = Laboratory(tmp_path / "data")
    absent = DeadMan("/nowhere", 1)
    monkeypatch.setattr(absent, "_spawn", refuse)
    lab.rig._stop._watches = (absent,)
    lab.rig.estop("berta", "smoke")
    with pytest.raises(DeviceError, match="cannot start"):
        lab.rig.release("berta", "only steam")
    assert (lab.state, lab.cut_off.power) == ("estop", False)
    lab.close()


def refuse() -> subprocess.Popen[bytes]:
    raise DeviceError("cannot start", part="dead man")


def test_a_dead_man_that_ended_by_itself_stops_the_rig(tmp_path: Path, relay: Relay) -> None:
    lab = Laboratory(tmp_path / "data", threads=True)
    man = DeadMan(relay.path, 1, silent_s=10 * BOUND_S)
    lab.rig._stop._watches = (man,)
    lab.rig.estop("berta", "smoke")
    lab.rig.release("berta", "only steam")
    assert man._process is not None
    man._process.kill()
    until(lambda: lab.state == "estop")
    assert lab.cut_off.power is False
    lab.close()


class Box(FakeTrigger):
    """A trigger that could watch."""

    def watch(self, within_s: float) -> bool:
        return True

    def beat(self) -> bool:
        return True

    def end_watch(self) -> None: ...


def test_real_devices_alone_are_watched_and_where_a_cut_lets_no_sphere_go() -> None:
    box = Actuators(Box([], "trigger"), None, None, FakeCutOff([], "cut_off"))

    def kinds(configuration: Configuration) -> list[str]:
        return [type(watch).__name__ for watch in _watches(configuration, box)]

    pusher, release = (load(Path(f"config/{name}.toml")) for name in ("pusher", "release"))
    assert kinds(load()) == []
    assert kinds(pusher) == ["DeadMan", "BoxWatch"]
    assert kinds(release) == []
    relay = pusher.cut_off.model_copy(update={"dead_man": False})
    assert kinds(pusher.model_copy(update={"cut_off": relay})) == ["BoxWatch"]
    trigger = pusher.trigger.model_copy(update={"heartbeat": False})
    assert kinds(pusher.model_copy(update={"trigger": trigger})) == ["DeadMan"]
