"""What the process of a job, which runs the files of own effects, is kept from."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rigctl.jobs import JobFailedError, Task, in_process
from rigctl.jobs.worker import ENCLOSED, ON_NETWORK
from rigctl.jobs.worker_process import hide_from_jobs

SECRET = "the key of the daemon"


@pytest.fixture(autouse=True)
def stand_in(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    monkeypatch.setenv("RIGCTL_KEY", SECRET)
    monkeypatch.setenv("PGPASSWORD", SECRET)


@pytest.fixture
def port() -> Iterator[int]:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        yield listening.getsockname()[1]


@pytest.fixture
def secret(tmp_path: Path) -> Iterator[Path]:
    path = tmp_path / "service.json"
    path.write_text(SECRET)
    descriptor = os.open(path, os.O_RDONLY)
    # Inherited by a process that does not take care.
    os.set_inheritable(descriptor, True)
    yield path
    os.close(descriptor)


def surroundings(port: int, secret: Path, **more: Any) -> tuple[dict[str, Any], str]:
    """Return what a job finds around itself, and what its record says."""
    words: list[str] = []
    asked = {"port": port, "secret": str(secret), **more}
    work = in_process("stand_in_work:surroundings", asked, 60.0)
    return json.loads(work(Task(lambda _text, _share: None, words.append))), words[0]


def test_a_job_has_neither_secret_variables_nor_descriptors_of_the_daemon(
    port: int, secret: Path
) -> None:
    found, _ = surroundings(port, secret)
    assert SECRET not in found["environment"]
    assert "RIGCTL_KEY" not in found["environment"]
    assert "PATH" in found["environment"]
    assert str(secret) not in found["descriptors"]
    sockets = [name for name in found["descriptors"] if name.startswith("socket:")]
    assert sockets == []


def test_a_job_has_no_network_and_cannot_read_what_is_hidden(port: int, secret: Path) -> None:
    hide_from_jobs(secret)
    found, record = surroundings(port, secret)
    if record != ENCLOSED:
        pytest.skip(f"this kernel allows less: {record}")
    assert found["network"] != "open"
    assert found["read"] == {"here": "", "daemon": "PermissionError"}
    assert found["child"] == ""
    assert not found["bared"]
    assert secret.read_text() == SECRET


def test_a_job_keeps_the_network_where_the_catalogue_is_on_a_server(
    port: int, secret: Path
) -> None:
    found, record = surroundings(port, secret, database="postgresql://host/rig")
    if record != ON_NETWORK:
        pytest.skip(f"this kernel allows less: {record}")
    assert found["network"] == "open"


def test_a_kernel_that_refuses_is_named_in_the_record(monkeypatch: pytest.MonkeyPatch) -> None:
    from rigctl.jobs import worker

    def refuse(name: str, *_: object) -> None:
        raise PermissionError(1, "Operation not permitted", name)

    monkeypatch.setattr(worker, "_call", refuse)
    assert worker.enclose([], network=False) == (
        "network and key file are open to it: the kernel gives no namespaces "
        "(Operation not permitted)"
    )


def test_the_daemon_unpacks_no_object_that_a_job_sends(tmp_path: Path) -> None:
    harm = tmp_path / "harm"
    work = in_process("stand_in_work:packs_an_object", {"harm": str(harm)}, 60.0)
    with pytest.raises(JobFailedError, match="sent what is no message of a job"):
        work(Task(lambda _text, _share: None))
    assert not harm.exists()
