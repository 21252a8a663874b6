"""One key for the service: who may ask, checked before anything of a request is read."""

from __future__ import annotations

import hashlib
import secrets

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from rigctl.service.problems import Problem, answer

PREFIX = "/api/v1"
ESTOP_PATH = f"{PREFIX}/rig/estop"


def new_key() -> str:
    """Return a fresh key of 192 random bits, safe in a URL."""
    return secrets.token_urlsafe(24)


class KeyGuard:
    """Lets a request through to `/api/v1` only with `Authorization: Bearer KEY`.

    The emergency stop is open to every caller that reaches the service: a stop that waits for the
    right key is no stop. Health and the OpenAPI document lie outside `/api/v1` and are open too.
    Each request learns its `actor`, the name under which the rig journals what it does: a
    fingerprint of the key, never the key.
    """

    def __init__(self, app: ASGIApp, key: str) -> None:
        self._app = app
        self._key = key.encode()
        self._fingerprint = hashlib.sha256(self._key).hexdigest()[:8]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer 401, or name the actor and pass the request on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        held = self._holds(Headers(scope=scope).get("authorization", ""))
        caller = f"key {self._fingerprint}" if held else "no key"
        client = scope.get("client")
        scope.setdefault("state", {})["actor"] = f"{caller} at {client[0] if client else 'unknown'}"
        if held or not scope["path"].startswith(f"{PREFIX}/") or scope["path"] == ESTOP_PATH:
            await self._app(scope, receive, send)
            return
        refusal = Problem(
            status=401,
            code="unauthorized",
            title="The key is missing or wrong",
            detail="the request carries no Authorization: Bearer header with this daemon's key",
            field="Authorization",
            todo="take the key that `rigctl serve` printed when it started",
        )
        await answer(refusal, {"WWW-Authenticate": 'Bearer realm="rigctl"'})(scope, receive, send)

    def _holds(self, header: str) -> bool:
        scheme, _, given = header.partition(" ")
        # A comparison in constant time: its duration tells nothing about the key.
        same = secrets.compare_digest(given.strip().encode(), self._key)
        return same and scheme.lower() == "bearer"
