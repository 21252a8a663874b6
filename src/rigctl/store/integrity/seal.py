"""The key that closes the entries of the ledger, in a file that only the store's owner reads."""

from __future__ import annotations

import hashlib
import hmac
import json
import os
import secrets
from pathlib import Path

from rigctl.errors import StoreError
from rigctl.store.durable import sync_folder

FILE_NAME = "audit.key"
_BYTES = 32


class Seal:
    """Closes entries with HMAC-SHA-256: a valid entry cannot be made without the key."""

    def __init__(self, key: bytes) -> None:
        self._key = key

    def digest(self, previous: str, fields: tuple[object, ...]) -> str:
        """Return the digest of an entry's fields after the digest of the entry before it."""
        text = json.dumps([previous, *fields], separators=(",", ":"))
        return hmac.new(self._key, text.encode(), hashlib.sha256).hexdigest()

    def keep(self, folder: Path) -> None:
        """Write the key into a folder that has none, with mode 0600, and force it to disk.

        Raises
        ------
        StoreError
            The file is there, or the disk refused.
        """
        path = folder / FILE_NAME
        try:
            # The mode is given at creation: the key is never readable to others.
            descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            with os.fdopen(descriptor, "w", encoding="ascii") as file:
                file.write(f"{self._key.hex()}\n")
                file.flush()
                os.fsync(file.fileno())
            sync_folder(folder)
        except OSError as error:
            raise StoreError(
                f"the key of the audit cannot be written: {error.strerror}",
                part=str(path),
                todo="free disk space or correct the folder's rights",
            ) from error


def new_seal(folder: Path) -> Seal:
    """Draw a fresh key and keep it in a folder; raise as `Seal.keep`."""
    seal = Seal(secrets.token_bytes(_BYTES))
    seal.keep(folder)
    return seal


def read_seal(folder: Path) -> Seal | None:
    """Return the seal whose key lies in a folder; None where there is no file.

    Raises
    ------
    StoreError
        The file cannot be read or holds no key.
    """
    secret = read_secret(folder)
    return None if secret is None else Seal(secret)


def read_secret(folder: Path) -> bytes | None:
    """Return the key that lies in a folder; None and errors as `read_seal`."""
    path = folder / FILE_NAME
    try:
        key = bytes.fromhex(path.read_text(encoding="ascii").strip())
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        what = error.strerror if isinstance(error, OSError) else "it holds no key"
        raise StoreError(
            f"the key of the audit cannot be read: {what}",
            part=str(path),
            todo="run the command as the user of the daemon, or restore the file from a backup",
        ) from error
    if len(key) != _BYTES:
        raise StoreError(
            "the key of the audit is cut",
            part=str(path),
            value=f"{len(key)} bytes",
            limit=f"{_BYTES} bytes",
            todo="restore the file from a backup",
        )
    return key
