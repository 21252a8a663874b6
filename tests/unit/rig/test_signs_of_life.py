"""What the daemon tells the service manager, and what it writes into the log."""

from __future__ import annotations

import json
import logging
import socket
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest

from rigctl import logs
from rigctl.cli.rig import serve
from rigctl.errors import DeviceAbsentError
from rigctl.logs import JsonFormatter, TextFormatter
from rigctl.rig.states import RigState
from rigctl.rig.status import Transition

BOUND_S = 10.0


@pytest.fixture
def manager(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[socket.socket]:
    path = tmp_path / "notify"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as link:
        link.bind(str(path))
        link.settimeout(BOUND_S)
        monkeypatch.setenv("NOTIFY_SOCKET", str(path))
        yield link


def test_a_state_reaches_the_service_manager(manager: socket.socket) -> None:
    serve.notify(serve.READY)
    assert manager.recv(64) == b"READY=1"


def test_without_a_service_manager_nothing_happens(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NOTIFY_SOCKET", raising=False)
    serve.notify(serve.READY)
    monkeypatch.setenv("NOTIFY_SOCKET", "/nowhere/at/all")
    serve.notify(serve.READY)


def test_signs_of_life_come_as_long_as_the_daemon_answers(
    manager: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WATCHDOG_USEC", "30000")
    answers = [True, True, False]
    watchdog = serve.Watchdog(lambda: answers.pop(0) if answers else False)
    assert [manager.recv(64) for _ in range(2)] == [b"WATCHDOG=1"] * 2
    manager.settimeout(0.2)
    with pytest.raises(TimeoutError):
        manager.recv(64)
    watchdog.close()


@pytest.mark.parametrize("period", ["", "often"])
def test_a_unit_without_a_watchdog_gets_none(period: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WATCHDOG_USEC", period)
    assert serve.watchdog_period_s() is None


def test_a_step_of_the_rig_is_one_line_of_json_with_its_shot(
    caplog: pytest.LogCaptureFixture,
) -> None:
    at = datetime(2026, 1, 31, tzinfo=UTC)
    # By name: a command run in this process may have left the rig's steps unwritten.
    with caplog.at_level(logging.INFO, logger="rigctl.rig"):
        logs.transition(
            Transition(RigState.ARMED, RigState.FIRING, at, "anna", "a\nbreak", "20260131-000001")
        )
    text = JsonFormatter().format(caplog.records[-1])
    line = json.loads(text)
    assert "\n" not in text
    assert (line["shot"], line["state"], line["actor"]) == ("20260131-000001", "firing", "anna")
    assert line["level"] == "info"


def test_an_exception_is_in_its_line(caplog: pytest.LogCaptureFixture) -> None:
    try:
        raise ZeroDivisionError("nothing to divide by")
    except ZeroDivisionError:
        logging.getLogger("rigctl").exception("it failed")
    line = json.loads(JsonFormatter().format(caplog.records[-1]))
    assert "ZeroDivisionError" in line["trace"]


@pytest.mark.parametrize(
    ("error", "traced"),
    [(ZeroDivisionError("nothing to divide by"), True), (DeviceAbsentError("hung up"), False)],
)
def test_a_person_reads_a_trace_only_of_what_has_no_name(
    error: Exception, traced: bool, caplog: pytest.LogCaptureFixture
) -> None:
    try:
        raise error
    except type(error):
        logging.getLogger("rigctl").exception("it failed")
    assert ("Traceback" in TextFormatter().format(caplog.records[-1])) is traced
    # What else reads the record still has it.
    assert "trace" in json.loads(JsonFormatter().format(caplog.records[-1]))
