"""Where the running service is and its key, in a file that only its owner can read."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path

from rigctl.errors import ConfigurationError, StoreError

FILE_NAME = "service.json"


@dataclass(frozen=True, slots=True)
class ServiceAddress:
    """Address of a running service, as in `http://127.0.0.1:8486`, and the key that opens it.

    `certificate` is the file by which clients verify an encrypted service; None: a public CA.
    `stop_url` is the address of the emergency stop's own port; empty without one.
    """

    url: str
    key: str
    certificate: str | None = None
    stop_url: str = ""


def write(folder: Path, address: ServiceAddress) -> Path:
    """Write the key file with mode 0600 into the store's folder and return its path.

    Raises
    ------
    StoreError
        The folder or the file cannot be written.
    """
    path = folder / FILE_NAME
    beside = path.with_suffix(".tmp")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        beside.unlink(missing_ok=True)
        # The mode is given at creation: the key is never readable to others, not for a moment.
        descriptor = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            json.dump(asdict(address), file)
        beside.replace(path)
    except OSError as error:
        raise StoreError(
            f"the key file cannot be written: {error.strerror}",
            part=str(path),
            todo="make the store's folder writable",
        ) from error
    return path


def read(folder: Path) -> ServiceAddress:
    """Return what the running service wrote.

    Raises
    ------
    ConfigurationError
        No service wrote a key file there, or it cannot be read or understood.
    """
    path = folder / FILE_NAME
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        certificate, stop_url = content.get("certificate"), str(content.get("stop_url", ""))
        return ServiceAddress(str(content["url"]), str(content["key"]), certificate, stop_url)
    except FileNotFoundError as error:
        raise ConfigurationError(
            "no daemon runs on this store",
            part=str(path),
            todo="start one with `rigctl serve`, give --key, or fire with --local",
        ) from error
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise ConfigurationError(
            f"the key file cannot be used: {error}",
            part=str(path),
            todo="start `rigctl serve` again, or give --key",
        ) from error
