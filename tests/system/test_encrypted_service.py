"""A daemon with a certificate: commands find it, strangers do not, and plain text is not served."""

from __future__ import annotations

import json
import os
import shutil
import ssl
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from rigctl.config.loading import default_path
from tests.invoked import rigctl

RIGCTL = [sys.executable, "-c", "from rigctl.cli import main; main()"]
ENVIRONMENT = {**os.environ, "RIGCTL_KEY": ""}
WAIT_S = 60.0
OPENSSL = shutil.which("openssl")

pytestmark = pytest.mark.skipif(OPENSSL is None, reason="no openssl makes a certificate")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder in which an encrypting daemon runs on its own certificate."""
    folder = tmp_path_factory.mktemp("encrypted")
    made = [OPENSSL, "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"]
    made += ["-nodes", "-days", "2", "-subj", "/CN=rig", "-addext", "subjectAltName=IP:127.0.0.1"]
    made += ["-keyout", "rig.key.pem", "-out", "rig.pem"]
    subprocess.run(made, cwd=folder, check=True, capture_output=True, timeout=WAIT_S)
    plain = default_path().read_text()
    lines = '[service]\ntls_certificate = "rig.pem"\ntls_key = "rig.key.pem"\n'
    (folder / "rig.toml").write_text(plain.replace("[service]\n", lines))
    command = [*RIGCTL, "serve", "--config", "rig.toml", "--port", "0"]
    process = subprocess.Popen(
        command, cwd=folder, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert "https://127.0.0.1:" in process.stdout.readline()
    yield folder
    process.terminate()
    process.communicate(timeout=WAIT_S)


def address(folder: Path) -> str:
    return str(json.loads((folder / "data/service.json").read_text())["url"])


def test_commands_on_the_host_trust_the_configured_certificate(folder: Path) -> None:
    for words in (("stop", "--reason", "a test"), ("release", "the test has ended")):
        done = rigctl(*words, "--config", "rig.toml", folder=folder, key="")
        assert done.returncode == 0, done.stderr


def test_who_does_not_know_the_certificate_speaks_to_nobody(folder: Path) -> None:
    with pytest.raises(httpx.ConnectError, match="certificate"):
        httpx.get(f"{address(folder)}/health/live", timeout=WAIT_S)
    trusting = ssl.create_default_context(cafile=str(folder / "rig.pem"))
    with httpx.Client(verify=trusting, timeout=WAIT_S) as client:
        assert client.get(f"{address(folder)}/health/live").is_success


def test_nothing_is_answered_unencrypted(folder: Path) -> None:
    with pytest.raises(httpx.TransportError):
        httpx.get(f"{address(folder).replace('https', 'http')}/health/live", timeout=WAIT_S)
