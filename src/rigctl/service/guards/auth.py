"""Who may ask for what, checked before anything of a request is read."""

from __future__ import annotations

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rigctl.access.keyring import Holder, Keyring
from rigctl.access.scopes import ESTOP_PATH, PREFIX, allows, needed
from rigctl.access.wrong_keys import WrongKeys
from rigctl.service.problems import Problem, answer

__all__ = ["ESTOP_PATH", "PREFIX", "KeyGuard", "address_of"]


class KeyGuard:
    """Lets a request through to `/api/v1` only with `Authorization: Bearer KEY`.

    The emergency stop is open to every caller that reaches the service: a stop that waits for the
    right key is no stop. Health and the OpenAPI document lie outside `/api/v1` and are open too.
    Each request learns its `actor`, the name under which the rig journals what it does: the name
    of the key, or a fingerprint of the daemon's own, never a key.
    """

    def __init__(self, app: ASGIApp, keyring: Keyring, wrong: WrongKeys) -> None:
        self._app, self._keyring, self._wrong = app, keyring, wrong

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer 401 or 403, or name the actor and pass the request on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        address = address_of(scope)
        given = _given(Headers(scope=scope).get("authorization", ""))
        holder, why = self._keyring.holder(given)
        caller = "no key" if holder is None else holder.name
        scope.setdefault("state", {})["actor"] = f"{caller} at {address}"
        path = scope["path"]
        if path == ESTOP_PATH:
            if holder is None and given:
                self._wrong.note(address)
        elif path.startswith(f"{PREFIX}/"):
            if holder is None:
                if given:
                    await self._wrong.refuse(address)
                headers = {"WWW-Authenticate": 'Bearer realm="rigctl"'}
                await answer(_unknown(given, why), headers)(scope, receive, send)
                return
            refusal = _not_allowed(holder, scope["method"], path)
            if refusal is not None:
                await answer(refusal)(scope, receive, send)
                return
            send = self._until_revoked(given, send)
        await self._app(scope, receive, send)

    def _until_revoked(self, given: str, send: Send) -> Send:
        """Return what ends an answer that is still being given when its key opens nothing more."""
        ended = False

        async def sent(message: Message) -> None:
            nonlocal ended
            if ended:
                return
            if message["type"] == "http.response.body" and message.get("more_body"):
                holder, _ = self._keyring.holder(given)
                if holder is None:
                    ended = True
                    message = {"type": "http.response.body", "body": b"", "more_body": False}
            await send(message)

        return sent


def address_of(scope: Scope) -> str:
    """Return the address of the client."""
    client = scope.get("client")
    return str(client[0]) if client else "unknown"


def _given(header: str) -> str:
    scheme, _, key = header.partition(" ")
    return key.strip() if scheme.lower() == "bearer" else ""


def _unknown(given: str, why: str) -> Problem:
    missing = "the request carries no Authorization: Bearer header"
    return Problem(
        status=401,
        code="unauthorized",
        title="The key is missing or wrong",
        detail=f"the key opens nothing: {why}" if given else missing,
        field="Authorization",
        todo="take the key that `rigctl serve` printed when it started, or one of `rigctl keys`",
    )


def _not_allowed(holder: Holder, method: str, path: str) -> Problem | None:
    scope = needed(method, path)
    if allows(holder.scopes, scope):
        return None
    return Problem(
        status=403,
        code="scope-missing",
        title="The key does not allow this",
        detail=f"{method} {path} needs the scope {scope!s}, which the key of {holder.name} lacks",
        field="Authorization",
        value=" ".join(sorted(holder.scopes)),
        limit=str(scope),
        todo=f"ask for a key with the scope {scope!s}: rigctl keys add NAME --scope {scope!s}",
    )
