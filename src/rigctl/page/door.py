"""The page's door: the key in the address becomes a session, and only a session sees the page."""

from __future__ import annotations

import hashlib
import hmac
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rigctl.service.auth import PREFIX

FRONT = "/"
OPEN = ("/health/", "/metrics", "/openapi.json")


class PageDoor:
    """Hands a request to the REST application, to the page, or to nobody.

    The address that `rigctl serve` prints holds the key. Opened once, it leaves a cookie and loses
    the key: neither history nor a screenshot shows it. The cookie's value is derived from the key,
    so that a daemon started again with the same key knows its operators.

    Parameters
    ----------
    api
        Answers below `/api/v1`, the paths of `OPEN`, and `/` to those without a session.
    page
        Answers everything else, and gets the life of the server: it starts `api`.
    key
        Of the service.
    """

    def __init__(self, api: ASGIApp, page: ASGIApp, key: str) -> None:
        self._api, self._page, self._key = api, page, key.encode()
        # Cookies know no port: two daemons on one host must not take each other's.
        self._name = f"rigctl-{hashlib.sha256(self._key).hexdigest()[:8]}"
        self._value = hmac.new(self._key, b"session of the page", "sha256").hexdigest()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request, one socket, or the life of the server."""
        if scope["type"] == "lifespan":
            await self._page(scope, receive, send)
            return
        path = str(scope["path"])
        if path.startswith((f"{PREFIX}/", *OPEN)):
            await self._api(scope, receive, send)
        elif self._is_own(scope) and not (path == FRONT and _key_of(scope)):
            await self._shown(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 4401})
        elif path == FRONT:
            await self._front(scope, receive, send)
        else:
            await RedirectResponse(FRONT, 303)(scope, receive, send)

    async def _shown(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the page answer; whoever left meanwhile needs no answer, and none is a fault."""
        gone = False

        async def received() -> Message:
            nonlocal gone
            message = await receive()
            gone = gone or message["type"] == "http.disconnect"
            return message

        try:
            await self._page(scope, received, send)
        except RuntimeError:
            # Starlette's middleware raises it where the page gave up a request without answer.
            if not gone:
                raise

    async def _front(self, scope: Scope, receive: Receive, send: Send) -> None:
        given = _key_of(scope)
        if given is None:
            await self._api(scope, receive, send)
        elif hmac.compare_digest(given.encode(), self._key):
            await self._opened()(scope, receive, send)
        else:
            text = "This is not the key of the daemon that runs here; take the one it printed.\n"
            await PlainTextResponse(text, 401)(scope, receive, send)

    def _opened(self) -> Response:
        response = RedirectResponse(FRONT, 303)
        response.set_cookie(self._name, self._value, httponly=True, samesite="strict")
        return response

    def _is_own(self, scope: Scope) -> bool:
        """Say whether a session is there; who else shares its cookie, `OriginGuard` refuses."""
        held = self._held(Headers(scope=scope))
        return hmac.compare_digest(held.encode(), self._value.encode())

    def _held(self, headers: Headers) -> str:
        try:
            cookie = SimpleCookie(headers.get("cookie", "")).get(self._name)
        except CookieError:
            return ""
        return "" if cookie is None else cookie.value


def _key_of(scope: Scope) -> str | None:
    given = parse_qs(scope["query_string"].decode("latin-1")).get("key")
    return given[-1] if given else None
