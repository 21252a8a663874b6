"""Every key that opens the service now: the one of this start, and those with names."""

from __future__ import annotations

import hashlib
import hmac
import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from rigctl.access.named_keys import KeyFile, NamedKey, hashed
from rigctl.access.scopes import EVERYTHING, Scope
from rigctl.errors import RigError
from rigctl.store.integrity.seal import read_secret

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Holder:
    """Holder of a key: the name in the audit, and the scopes of the key.

    `session` is the value of the page's cookie; it is derived from the key and ends with it.
    """

    name: str
    scopes: frozenset[Scope]
    session: str


class Keyring:
    """Finds holders by their keys. A key is refused at once when it is revoked or has expired.

    Parameters
    ----------
    key
        Of this start of the daemon; it may do everything.
    folder
        Of the store, where named keys lie; called only where another key is given.
    now
        The clock, UTC.
    """

    def __init__(
        self,
        key: str,
        folder: Callable[[], Path],
        now: Callable[[], datetime] = lambda: datetime.now(UTC),
    ) -> None:
        self._key, self._folder, self._now = key.encode(), folder, now
        fingerprint = hashlib.sha256(self._key).hexdigest()[:8]
        self.cookie = f"rigctl-{fingerprint}"
        self._own = Holder(f"key {fingerprint}", EVERYTHING, _session(self._key))
        self._lock = threading.Lock()
        self._mark: object = None
        self._named: list[NamedKey] = []

    def holder(self, given: str) -> tuple[Holder | None, str]:
        """Return the holder of a key, or None and why it is refused."""
        # Compared in constant time, so that timing reveals nothing about the key.
        if hmac.compare_digest(given.encode(), self._key):
            return self._own, ""
        named = self._present() if given else []
        secret = read_secret(self._folder()) if named else None
        if secret is not None:
            digest = hashed(given, secret)
            for key in named:
                if hmac.compare_digest(digest, key.digest):
                    why = key.refusal(self._now())
                    return (None, why) if why else (_holder(key), "")
        return None, "it is not the key of this daemon, and no named key"

    def of_session(self, value: str) -> Holder | None:
        """Return whose session of the page this is, as long as the key opens anything."""
        holders = [self._own]
        if value:
            now = self._now()
            holders += [_holder(key) for key in self._present() if key.refusal(now) is None]
        found = (h for h in holders if hmac.compare_digest(h.session.encode(), value.encode()))
        return next(found, None)

    def _present(self) -> list[NamedKey]:
        """Return the named keys as the file has them now; none while it cannot be read."""
        file = KeyFile(self._folder())
        with self._lock:
            try:
                mark = file.mark()
                if mark != self._mark:
                    self._named, self._mark = file.all(), mark
            except (RigError, OSError):
                _log.exception("no named key opens anything")
                self._named, self._mark = [], None
            return self._named


def _holder(key: NamedKey) -> Holder:
    return Holder(key.name, frozenset(key.scopes), _session(key.digest.encode()))


def _session(secret: bytes) -> str:
    return hmac.new(secret, b"session of the page", "sha256").hexdigest()
