from __future__ import annotations

import contextlib
import json
import os
import selectors
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial

REPOSITORY = Path(__file__).parents[3]
START_WITHIN_S, END_WITHIN_S = 60.0, 60.0


class Process:
    """`python -m simulators` in a folder, and a connection to its control socket."""

    def __init__(self, folder: Path) -> None:
        command = [sys.executable, "-W", "error", "-m", "simulators", str(folder), "--seed", "5"]
        self.popen = subprocess.Popen(
            command, cwd=REPOSITORY, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        with selectors.DefaultSelector() as ready:
            assert self.popen.stdout is not None
            ready.register(self.popen.stdout, selectors.EVENT_READ)
            assert ready.select(START_WITHIN_S)
            self.paths: dict[str, str] = json.loads(self.popen.stdout.readline())
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.settimeout(60.0)
        self._socket.connect(self.paths["control"])
        self._stream = self._socket.makefile("rw")

    def tell(self, request: object) -> dict[str, object]:
        self._stream.write(json.dumps(request) + "\n")
        self._stream.flush()
        return dict(json.loads(self._stream.readline()))

    def close(self) -> None:
        self._stream.close()
        self._socket.close()
        if self.popen.poll() is None:
            self.popen.kill()
        self.popen.communicate(timeout=END_WITHIN_S)


@pytest.fixture
def process(tmp_path: Path) -> Iterator[Process]:
    process = Process(tmp_path)
    yield process
    process.close()


def test_a_laboratory_in_its_own_process_is_reached_faulted_and_ended(
    process: Process, tmp_path: Path
) -> None:
    ports = {"trigger", "regulator", "slide", "cut-off", "recorder"}
    assert {role: process.paths[role] for role in ports} == {
        role: str(tmp_path / role) for role in ports
    }
    with serial.Serial(process.paths["recorder"], timeout=60.0) as port:
        port.write(b"ID?\n")
        assert port.read_until(b"\n") == b"OK EKTAPRO-SIM 2\n"
        fault = {"device": "recorder", "kind": "half-answer", "times": 1}
        assert process.tell({"fault": fault}) == {"ok": True}
        port.write(b"ID?\n")
        assert port.read(8) == b"OK EKTAP"

    assert process.tell({"contact": True}) == {"ok": True}
    state = process.tell({"state": True})["state"]
    assert isinstance(state, dict)
    assert state["recorder"] in {"STARTING", "RECORD"}
    assert (state["fires"], state["powered"]) == (0, False)
    assert process.tell({"clear": True}) == {"ok": True}
    for request, named in [
        ({"fault": {"device": "laser", "kind": "stuck"}}, "laser"),
        ({"fault": {"device": "slide", "kind": "stuck", "colour": 1}}, "colour"),
        ({"fault": {"device": "slide", "kind": "deaf", "times": "2"}}, "times"),
        ({"state": True, "clear": True}, "a request is one of"),
        ({"contact": 1}, "a request is one of"),
        ([], "a request is one of"),
    ]:
        assert named in str(process.tell(request)["error"])

    process.popen.send_signal(signal.SIGTERM)
    assert process.popen.wait(END_WITHIN_S) == 0
    assert process.popen.stderr is not None
    assert process.popen.stderr.read() == ""
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {"capture", "truth"}


def test_a_laboratory_follows_a_killed_one_in_the_same_folder(tmp_path: Path) -> None:
    first = Process(tmp_path)
    first.popen.kill()
    first.close()
    assert os.path.lexists(tmp_path / "trigger")
    with (
        contextlib.closing(Process(tmp_path)) as second,
        serial.Serial(second.paths["trigger"], timeout=60.0) as port,
    ):
        port.write(b"ID?*32\n")
        assert port.read_until(b"\n").startswith(b"RIGTRIG 2 2*")
