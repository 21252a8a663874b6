"""The daemon as it is run: its own process, real sockets, the simulated rig."""

from __future__ import annotations

import json
import os
import signal
import stat
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import httpx
import numpy as np
import pytest
import uvicorn

from rigctl.daemon import Daemon, open_daemon
from rigctl.service.app import create_app
from rigctl.service.events import EventHub
from rigctl.store import Fired, ShotState, Store
from tests.invoked import Invoked, rigctl
from tests.simulated import patient_text, with_short_films

SIMULATED = Path(__file__).parents[2] / "config" / "simulated.toml"
KEY = "live-key"
HEADERS = {"Authorization": f"Bearer {KEY}"}
SETTINGS = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": 6.0}
RIGCTL = [sys.executable, "-c", "from rigctl.cli import main; main()"]
WAIT_S = 60.0


def command(folder: Path, *arguments: str) -> Invoked:
    return rigctl(*arguments, folder=folder, key="")


@contextmanager
def daemon_process(folder: Path) -> Iterator[subprocess.Popen[str]]:
    rig = folder / "rig.toml"
    rig.write_text(patient_text(SIMULATED.read_text(encoding="utf-8")), encoding="utf-8")
    process = subprocess.Popen(
        [*RIGCTL, "serve", "--port", "0", "--config", "rig.toml"],
        cwd=folder,
        env={**os.environ, "RIGCTL_KEY": ""},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate(timeout=WAIT_S)


def greeting(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline()


def address(folder: Path) -> tuple[str, dict[str, str]]:
    written = json.loads((folder / "data" / "service.json").read_text())
    return written["url"], {"Authorization": f"Bearer {written['key']}"}


@pytest.fixture(scope="module")
def serving(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, str]]:
    """A daemon: the folder it runs in, and how it greets."""
    folder = tmp_path_factory.mktemp("serving")
    with daemon_process(folder) as process:
        yield folder, greeting(process)


def test_a_shot_goes_from_the_command_line_through_the_daemon_to_its_frames(
    serving: tuple[Path, str],
) -> None:
    folder, line = serving
    url, headers = address(folder)
    key = headers["Authorization"].removeprefix("Bearer ")
    assert f"{url}/?key={key}" in line
    assert "simulated" in line
    mode = (folder / "data" / "service.json").stat().st_mode
    assert stat.S_IMODE(mode) == 0o600

    order = ("shot", "--pressure-kpa", "40", "--offset-mm", "6", "--campaign", "one", "--json")
    done = command(folder, *order)
    document = json.loads(done.stdout)
    assert done.returncode == (0 if document["state"] == "analysed" else 4), done.stderr
    assert document["state"] in {"analysed", "refused"}
    assert (document["campaign"], document["fired"]) == ("one", "yes")
    assert document["result"]["shot"] == document["shot"]

    frame = httpx.get(
        f"{url}/api/v1/shots/{document['shot']}/frames/0.png", headers=headers, timeout=WAIT_S
    )
    picture = cv2.imdecode(np.frombuffer(frame.content, np.uint8), cv2.IMREAD_UNCHANGED)
    assert picture is not None
    assert picture.shape == (192, 240)

    for arguments, code, words in REFUSED:
        refused = command(folder, "shot", *arguments)
        assert (refused.returncode, refused.stdout) == (code, "")
        assert words in refused.stderr
    stopped = httpx.post(f"{url}/api/v1/rig/estop", timeout=WAIT_S)
    assert stopped.json()["state"] == "estop"
    refused = command(folder, *order)
    assert (refused.returncode, refused.stdout) == (3, "")
    assert "release" in refused.stderr


REFUSED = [
    (("--pressure-kpa", "121", "--offset-mm", "6"), 2, "5 to 120 kPa"),
    (("--pressure-kpa", "40", "--offset-mm", "6", "--key", "wrong"), 2, "key"),
    (("--pressure-kpa", "40", "--offset-mm", "6", "--local"), 3, "another process owns the store"),
]


@pytest.mark.parametrize(
    "number", [pytest.param(signal.SIGINT, marks=pytest.mark.long), signal.SIGTERM]
)
def test_a_signal_in_the_middle_of_a_shot_lets_it_end_and_stores_it_and_lets_listeners_go(
    tmp_path: Path, number: signal.Signals
) -> None:
    with daemon_process(tmp_path) as process:
        greeting(process)
        url, headers = address(tmp_path)
        with (
            httpx.Client(base_url=f"{url}/api/v1", headers=headers, timeout=WAIT_S) as client,
            client.stream("GET", "/events") as answer,
        ):
            lines = answer.iter_lines()
            assert next(lines) == "event: rig"
            token = client.post("/rig/arm", json=SETTINGS).json()["arm_token"]
            order = {"arm_token": token}
            shot = client.post("/shots", json=order, headers={"Idempotency-Key": "k"}).json()
            process.send_signal(number)
            assert "event: end" in list(lines)
        assert process.wait(WAIT_S) == 0
        assert not (tmp_path / "data" / "service.json").exists()
    store = Store(tmp_path / "data")
    try:
        record = store.shot(shot["shot"])
        assert (record.outcome, record.fired) == (ShotState.STORED, Fired.YES)
        last = store.journal.last()
        assert last is not None
        assert last.after == "idle"
    finally:
        store.close()


def test_a_port_that_is_taken_is_refused_before_any_device_is_opened(
    serving: tuple[Path, str], tmp_path: Path
) -> None:
    url, _ = address(serving[0])
    refused = command(tmp_path, "serve", "--port", url.rpartition(":")[2])
    assert refused.returncode == 2
    assert "--port" in refused.stderr
    assert not (tmp_path / "data").exists()


def test_the_network_is_refused_without_encryption(tmp_path: Path) -> None:
    default = SIMULATED.read_text(encoding="utf-8")
    open_to_all = default.replace('host = "127.0.0.1"', 'host = "0.0.0.0"')
    assert open_to_all != default
    (tmp_path / "rig.toml").write_text(open_to_all)
    key = ("--key", "key-of-the-thread-2026")
    refused = command(tmp_path, "serve", "--config", "rig.toml", *key)
    assert refused.returncode == 2
    assert "service.host" in refused.stderr
    assert "service.tls_certificate" in refused.stderr
    assert "key-of-the-thread-2026" not in refused.stderr + refused.stdout


@pytest.fixture
def daemon(tmp_path: Path) -> Iterator[Daemon]:
    with open_daemon(with_short_films(tmp_path / "data")) as opened:
        yield opened


class _Server(uvicorn.Server):
    def __init__(self, app: Any) -> None:
        super().__init__(uvicorn.Config(app, port=0, log_level="warning"))
        self.listening = threading.Event()

    async def startup(self, sockets: Any = None) -> None:
        await super().startup(sockets)
        self.listening.set()


@pytest.fixture
def client(daemon: Daemon) -> Iterator[httpx.Client]:
    hub = EventHub()
    server = _Server(create_app(daemon, KEY, hub))
    thread = threading.Thread(target=server.run)
    thread.start()
    assert server.listening.wait(WAIT_S)
    port = server.servers[0].sockets[0].getsockname()[1]
    url = f"http://127.0.0.1:{port}/api/v1"
    with httpx.Client(base_url=url, headers=HEADERS, timeout=WAIT_S) as opened:
        yield opened
    hub.close()
    server.should_exit = True
    thread.join(WAIT_S)
    assert not thread.is_alive()


def watch(daemon: Daemon, wanted: ShotState, act: Callable[[], None]) -> threading.Event:
    """Call `act` in a thread of its own once a shot reaches a state; return when it has been."""
    done = threading.Event()

    def work() -> None:
        act()
        done.set()

    def tell(record: Any) -> None:
        if record.state is wanted:
            threading.Thread(target=work).start()

    daemon.store.listeners.add(tell)
    return done


def test_a_stop_reaches_the_power_while_the_fire_command_still_waits_for_its_answer(
    client: httpx.Client, daemon: Daemon
) -> None:
    laboratory: Any = daemon.laboratory
    laboratory.fault("trigger", "late-answer", command="FIRE", delay_s=0.4, times=1)
    found: list[tuple[bool, ShotState]] = []

    def stop() -> None:
        httpx.post(f"{client.base_url}rig/estop", json={"reason": "smoke"}, timeout=WAIT_S)
        shot = daemon.store.shots()[0]
        found.append((laboratory.state()["powered"], shot.state))

    stopped = watch(daemon, ShotState.FIRING, stop)
    token = client.post("/rig/arm", json=SETTINGS).json()["arm_token"]
    shot = client.post(
        "/shots", json={"arm_token": token}, headers={"Idempotency-Key": "k"}
    ).json()["shot"]
    assert stopped.wait(WAIT_S)
    ((powered, _),) = found
    assert powered is False
    record = daemon.rig.wait(shot, WAIT_S)
    assert record.outcome in {ShotState.UNKNOWN_OUTCOME, ShotState.ABORTED, ShotState.MISFIRE}
    rig = client.get("/rig").json()
    assert (rig["state"], "smoke" in rig["latch_reason"]) == ("estop", True)
    assert laboratory.fires <= 1
    refused = client.post("/rig/arm", json=SETTINGS)
    assert (refused.status_code, refused.json()["code"]) == (409, "refused")
    released = client.post("/rig/release", json={"reason": "looked, all clear"})
    assert released.json()["state"] == "idle"
    assert laboratory.state()["powered"] is True


def test_events_tell_the_whole_way_of_a_shot(client: httpx.Client) -> None:
    with client.stream("GET", "/events") as answer:
        lines = answer.iter_lines()
        token = httpx.post(
            f"{client.base_url}rig/arm", json=SETTINGS, headers=HEADERS, timeout=WAIT_S
        ).json()["arm_token"]
        httpx.post(
            f"{client.base_url}shots",
            json={"arm_token": token},
            headers={**HEADERS, "Idempotency-Key": "k"},
            timeout=WAIT_S,
        )
        told: list[str] = []
        for line in lines:
            if line.startswith("data: "):
                told.append(json.loads(line.removeprefix("data: "))["state"])
            if told[-1:] in (["analysed"], ["refused"]):
                break
    rig_and_shot = [state for n, state in enumerate(told) if told.index(state) == n]
    way = ["idle", "checked", "armed", "firing", "capturing", "stored", "analysing"]
    assert [state for state in rig_and_shot if state in way] == way
