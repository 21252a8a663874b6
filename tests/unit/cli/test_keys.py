"""Keys by command: strong ones, from where nobody sees them, and named ones."""

from __future__ import annotations

import asyncio
import json
import socket
from pathlib import Path
from typing import Any

import httpx
import pytest

from rigctl.access.keyring import Keyring
from rigctl.access.strength import WARNING, chosen_key, new_key, require_strong
from rigctl.cli import BAD_INPUT, NOT_FOUND, run
from rigctl.cli.rig.serve import listen
from rigctl.config.configuration import ServiceSection
from rigctl.errors import ConfigurationError
from rigctl.service.guards.origins import behind_proxy
from rigctl.store import Store

WEAK = ["x", "x" * 40, "fifteen-letters", "a key with spaces in it", "schlüssel-der-anlage-2026"]
STRONG = ["key-of-the-thread-2026", "a" * 15 + "b", "~!@#$%^&*()_+-={}"]


@pytest.mark.parametrize("key", WEAK)
def test_a_weak_key_is_refused_and_not_repeated(key: str) -> None:
    with pytest.raises(ConfigurationError) as raised:
        require_strong(key)
    assert "at least 16 visible ASCII characters" in str(raised.value)
    assert len(key) < 3 or key not in str(raised.value)


@pytest.mark.parametrize("key", STRONG)
def test_a_strong_key_is_taken(key: str) -> None:
    require_strong(key)


def test_a_key_that_the_daemon_makes_is_strong() -> None:
    require_strong(new_key())


def test_the_daemon_refuses_a_weak_key_before_anything_is_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["serve", "--key", "x"]) == BAD_INPUT
    assert "too short with 1 characters" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_key_comes_by_option_file_or_environment_and_only_the_first_is_warned_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "rig.key"
    file.write_text("key-in-a-file-of-its-own\n")
    file.chmod(0o600)
    monkeypatch.setenv("RIGCTL_KEY", "key-in-the-environment")
    by_option = chosen_key("key-on-the-command-line", file)
    assert by_option is not None
    assert (by_option.key, by_option.warning) == ("key-on-the-command-line", WARNING)
    by_file = chosen_key(None, file)
    assert by_file is not None
    assert (by_file.key, by_file.warning) == ("key-in-a-file-of-its-own", None)
    by_environment = chosen_key(None, None)
    assert by_environment is not None
    assert (by_environment.key, by_environment.warning) == ("key-in-the-environment", None)
    file.chmod(0o644)
    open_to_all = chosen_key(None, file)
    assert open_to_all is not None
    assert "can be read by others" in str(open_to_all.warning)
    monkeypatch.setenv("RIGCTL_KEY", "")
    assert chosen_key(None, None) is None
    with pytest.raises(ConfigurationError, match="file of the key cannot be read"):
        chosen_key(None, tmp_path / "none")


@pytest.fixture
def config(tmp_path: Path) -> str:
    file = tmp_path / "rig.toml"
    source = Path("config/simulated.toml").read_text(encoding="utf-8")
    file.write_text(source.replace('folder = "data"', f'folder = "{tmp_path / "data"}"'))
    return str(file)


def test_a_named_key_is_printed_once_listed_without_its_hash_and_revoked(
    config: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    add = ["keys", "add", "anna", "--scope", "operate", "--scope", "sweep", "--expires", "30d"]
    assert run([*add, "--config", config, "--json"]) == 0
    key = json.loads(capsys.readouterr().out)["key"]
    keyring = Keyring("key-of-the-daemon", lambda: tmp_path / "data")
    holder, _ = keyring.holder(key)
    assert holder is not None
    assert (holder.name, sorted(holder.scopes)) == ("anna", ["operate", "sweep"])
    assert run(["keys", "list", "--config", config, "--json"]) == 0
    (listed,) = json.loads(capsys.readouterr().out)
    assert (listed["name"], listed["valid"]) == ("anna", True)
    assert "digest" not in listed
    session = keyring.of_session(holder.session)
    assert session is not None
    assert session.name == "anna"
    assert run(["keys", "revoke", "anna", "--config", config]) == 0
    assert keyring.holder(key)[0] is None
    assert keyring.of_session(holder.session) is None
    assert run(["keys", "revoke", "ben", "--config", config]) == NOT_FOUND
    store = Store(tmp_path / "data")
    acts = [(entry.act, entry.subject) for entry in store.edits.entries()]
    assert acts == [("key added", "anna"), ("key revoked", "anna")]
    store.close()


@pytest.mark.parametrize("expires", ["yesterday", "0d", "2020-01-01", "-3d"])
def test_an_end_that_is_none_or_past_is_refused(config: str, expires: str) -> None:
    add = ["keys", "add", "anna", "--scope", "read", f"--expires={expires}"]
    assert run([*add, "--config", config]) == BAD_INPUT


def section(**changes: Any) -> ServiceSection:
    return ServiceSection(**{"host": "127.0.0.1", "port": 0, **changes})


def test_the_network_is_refused_without_encryption_and_the_sentence_says_what_to_do() -> None:
    with pytest.raises(ConfigurationError, match=r"tls_certificate.*proxy.*127\.0\.0\.1"):
        listen(section(host="0.0.0.0"), None)
    with listen(section(host="0.0.0.0", proxy="10.0.0.2"), None) as listening:
        assert listening.family is socket.AF_INET
    with listen(section(), None) as listening:
        assert listening.getsockname()[0] == "127.0.0.1"


def test_a_certificate_that_is_none_is_refused_before_the_port_is_taken(tmp_path: Path) -> None:
    (tmp_path / "rig.pem").write_text("no certificate")
    pem = str(tmp_path / "rig.pem")
    with pytest.raises(ConfigurationError, match="certificate and key cannot be used"):
        listen(section(host="0.0.0.0", tls_certificate=pem, tls_key=pem), None)
    with pytest.raises(ValueError, match="given together"):
        section(tls_certificate=pem)


async def _reached(scope: Any, receive: Any, send: Any) -> None:
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": str(scope["client"][0]).encode()})


@pytest.mark.parametrize(
    ("client", "path", "status", "body"),
    [
        ("10.0.0.2", "/api/v1/rig", 200, "192.0.2.7"),
        ("10.0.0.9", "/api/v1/rig", 403, "not-by-proxy"),
        ("10.0.0.9", "/api/v1/rig/estop", 200, "10.0.0.9"),
    ],
)
def test_only_the_proxy_is_answered_and_it_says_who_asks(
    client: str, path: str, status: int, body: str
) -> None:
    app = behind_proxy(_reached, "10.0.0.2")

    async def ask() -> httpx.Response:
        transport = httpx.ASGITransport(app, client=(client, 4711))
        async with httpx.AsyncClient(transport=transport, base_url="http://rig") as caller:
            return await caller.get(path, headers={"X-Forwarded-For": "192.0.2.7"})

    answer = asyncio.run(ask())
    assert answer.status_code == status
    assert body in answer.text
