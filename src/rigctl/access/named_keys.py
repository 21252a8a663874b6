"""Named keys: each with its scopes, its end, and the keyed hash of the key, never the key.

They lie as `keys.json` in the store's folder, readable by its owner alone.
"""

from __future__ import annotations

import fcntl
import hashlib
import hmac
import json
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from pathlib import Path

from rigctl.access.scopes import Scope
from rigctl.errors import ConfigurationError, NotFoundError, SettingsError, StoreError
from rigctl.store.durable import sync_folder

FILE_NAME = "keys.json"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9._-]{0,31}")
_OWN = frozenset({"rig", "key", "no", "page", "sweep", "rigctl"})
"""Words with which the names of other actors begin."""


@dataclass(frozen=True, slots=True)
class NamedKey:
    """What is known of a key.

    Attributes
    ----------
    digest
        HMAC-SHA-256 of the key under the key of the store's audit.
    added_at, expires_at, revoked_at
        UTC, ISO 8601; None: it never expires, or is not revoked.
    """

    name: str
    scopes: tuple[Scope, ...]
    digest: str
    added_at: str
    expires_at: str | None = None
    revoked_at: str | None = None

    def refusal(self, now: datetime) -> str | None:
        """Return why the key opens nothing any more; None: it does."""
        if self.revoked_at is not None:
            return f"the key {self.name!r} was revoked at {self.revoked_at}"
        if self.expires_at is not None and datetime.fromisoformat(self.expires_at) <= now:
            return f"the key {self.name!r} expired at {self.expires_at}"
        return None


def hashed(key: str, secret: bytes) -> str:
    """Return the keyed hash under which a key is kept."""
    return hmac.new(secret, b"access key\0" + key.encode(), hashlib.sha256).hexdigest()


class KeyFile:
    """The named keys of a store; any process of its owner may change them."""

    def __init__(self, folder: Path) -> None:
        self._path, self._lock = folder / FILE_NAME, folder / ".keys.lock"

    def mark(self) -> tuple[int, int, int] | None:
        """Return what differs once the file was changed; None where there is none."""
        try:
            found = self._path.stat()
        except FileNotFoundError:
            return None
        return found.st_ino, found.st_mtime_ns, found.st_size

    def all(self) -> list[NamedKey]:
        """Return every key that was ever added.

        Raises
        ------
        ConfigurationError
            The file cannot be read or understood.
        """
        try:
            kept = json.loads(self._path.read_bytes())["keys"]
            return [NamedKey(**{**one, "scopes": tuple(map(Scope, one["scopes"]))}) for one in kept]
        except FileNotFoundError:
            return []
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise ConfigurationError(
                f"the file of named keys cannot be used: {error}",
                part=str(self._path),
                todo="restore it from a backup, or remove it and add the keys again",
            ) from error

    def add(self, key: NamedKey) -> None:
        """Add a key; a name is used once, also after its key was revoked.

        Raises
        ------
        SettingsError
            The name is none, or there is a key of this name.
        StoreError
            The disk refused.
        """
        if not _NAME.fullmatch(key.name) or key.name.lower() in _OWN:
            raise SettingsError(
                "is no name of a key",
                part="NAME",
                value=repr(key.name),
                limit="a letter, then up to 31 letters, digits, '.', '_' or '-'; not rig, key, "
                "no, page, sweep or rigctl",
                todo="name the person or program that is to hold it",
            )
        with self._changing() as known:
            if any(one.name == key.name for one in known):
                raise SettingsError(
                    "there is a key of this name",
                    part="NAME",
                    value=repr(key.name),
                    todo="take another: the audit must know one holder by each name",
                )
            known.append(key)

    def revoke(self, name: str, now: datetime) -> NamedKey:
        """Revoke a key; raise `NotFoundError` if there is none of that name."""
        with self._changing() as known:
            for place, one in enumerate(known):
                if one.name == name:
                    at = one.revoked_at or now.isoformat(timespec="seconds")
                    known[place] = replace(one, revoked_at=at)
                    return known[place]
        raise NotFoundError("no such key", value=repr(name), todo="see `rigctl keys list`")

    @contextmanager
    def _changing(self) -> Iterator[list[NamedKey]]:
        """Give the keys to be changed, to one process at a time; what they become is on disk."""
        try:
            with self._lock.open("w") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX)
                known = self.all()
                yield known
                self._write(known)
        except OSError as error:
            raise StoreError(
                f"the file of named keys cannot be written: {error.strerror}",
                part=str(self._path),
                todo="run the command as the user of the daemon, or free disk space",
            ) from error

    def _write(self, known: list[NamedKey]) -> None:
        partial = self._path.with_suffix(".partial")
        partial.unlink(missing_ok=True)
        # The mode is given at creation: the hashes are never readable to others.
        descriptor = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            json.dump({"format": 1, "keys": [asdict(one) for one in known]}, file, indent=1)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(self._path)
        sync_folder(self._path.parent)
