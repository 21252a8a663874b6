"""The file with the key of the daemon: who may read it, and which key goes before which."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rigctl import client as client_module
from rigctl.access.strength import Chosen
from rigctl.client import ServiceClient
from rigctl.errors import (
    ConfigurationError,
)
from rigctl.service import keyfile
from rigctl.service.keyfile import ServiceAddress


def test_the_key_file_is_its_owners_alone_and_holds_what_was_written(tmp_path: Path) -> None:
    address = ServiceAddress("http://127.0.0.1:8486", "secret")
    path = keyfile.write(tmp_path / "data", address)
    assert path.stat().st_mode & 0o777 == 0o600
    assert keyfile.read(tmp_path / "data") == address
    path.chmod(0o644)
    keyfile.write(tmp_path / "data", address)
    assert path.stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("content", ["", "{", "[]", "3", json.dumps({"url": "x"})])
def test_a_key_file_that_cannot_be_understood_says_so(tmp_path: Path, content: str) -> None:
    (tmp_path / keyfile.FILE_NAME).write_text(content)
    with pytest.raises(ConfigurationError, match="key file cannot be used"):
        keyfile.read(tmp_path)


def test_a_key_that_is_given_goes_before_the_written_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    keyfile.write(tmp_path / "data", ServiceAddress("http://127.0.0.1:1", "written"))
    seen: list[ServiceAddress] = []
    monkeypatch.setattr(client_module, "ServiceClient", opened_as(seen))
    for key in (Chosen("given"), None):
        with client_module.connected(None, key):
            pass
    assert [(address.url, address.key) for address in seen] == [
        ("http://127.0.0.1:1", "given"),
        ("http://127.0.0.1:1", "written"),
    ]


def opened_as(seen: list[ServiceAddress]) -> Any:
    class Noted(ServiceClient):
        def __init__(self, address: ServiceAddress) -> None:
            seen.append(address)
            super().__init__(address)

    return Noted
