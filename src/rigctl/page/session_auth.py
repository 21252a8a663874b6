"""Sessions of the page: the key in the address becomes a session, and only a session sees it."""

from __future__ import annotations

from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rigctl.access import scopes
from rigctl.access.keyring import Holder, Keyring
from rigctl.access.scopes import PREFIX, allows
from rigctl.access.wrong_keys import WrongKeys
from rigctl.service.guards.auth import address_of

FRONT = "/"
OPEN = ("/health/", "/metrics", "/openapi.json")
WANTED = (scopes.Scope.OPERATE, scopes.Scope.SWEEP, scopes.Scope.MAINTAIN)


class SessionAuth:
    """Hands a request to the REST application, to the page, or to nobody.

    The address that `rigctl serve` prints holds the key. Opened once, it leaves a cookie and loses
    the key: neither history nor a screenshot shows it. The cookie's value is derived from the key,
    so that a daemon started again with the same key knows its operators. It ends with the key; the
    page acts on everything, so only a key with every scope of `WANTED` opens it.

    Parameters
    ----------
    api
        Answers below `/api/v1`, the paths of `OPEN`, and `/` to those without a session.
    page
        Answers everything else, and gets the life of the server: it starts `api`.
    keyring, wrong
        The keys of the service, and the count of wrong ones.
    """

    def __init__(self, api: ASGIApp, page: ASGIApp, keyring: Keyring, wrong: WrongKeys) -> None:
        self._api, self._page = api, page
        self._keyring, self._wrong = keyring, wrong

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request, one socket, or the life of the server."""
        if scope["type"] == "lifespan":
            await self._page(scope, receive, send)
            return
        path = str(scope["path"])
        if path.startswith((f"{PREFIX}/", *OPEN)):
            await self._api(scope, receive, send)
        elif (holder := self._own(scope)) and not (path == FRONT and _key_of(scope)):
            scope.setdefault("state", {})["holder"] = holder.name
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
            if scope["type"] == "websocket" and self._own(scope) is None:
                # The key was revoked or has expired since the page was opened.
                return {"type": "websocket.disconnect", "code": 4401}
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
            return
        holder, why = self._keyring.holder(given)
        if holder is None:
            await self._wrong.refuse(address_of(scope))
            text = f"This key opens nothing: {why}; take the one that the daemon printed.\n"
            await PlainTextResponse(text, 401)(scope, receive, send)
        elif not _may_open(holder):
            text = (
                f"The page needs a key with the scopes {', '.join(WANTED)}; that of {holder.name} "
                "opens REST alone.\n"
            )
            await PlainTextResponse(text, 403)(scope, receive, send)
        else:
            await self._opened(holder, scope["scheme"])(scope, receive, send)

    def _opened(self, holder: Holder, scheme: str) -> Response:
        response = RedirectResponse(FRONT, 303)
        response.set_cookie(
            self._keyring.cookie,
            holder.session,
            httponly=True,
            samesite="strict",
            secure=scheme == "https",
        )
        return response

    def _own(self, scope: Scope) -> Holder | None:
        """Return whose session is there; who else shares its cookie, `OriginGuard` refuses."""
        held = self._held(Headers(scope=scope))
        holder = self._keyring.of_session(held) if held else None
        return holder if holder is not None and _may_open(holder) else None

    def _held(self, headers: Headers) -> str:
        try:
            cookie = SimpleCookie(headers.get("cookie", "")).get(self._keyring.cookie)
        except CookieError:
            return ""
        return "" if cookie is None else cookie.value


def _may_open(holder: Holder) -> bool:
    return all(allows(holder.scopes, scope) for scope in WANTED)


def _key_of(scope: Scope) -> str | None:
    given = parse_qs(scope["query_string"].decode("latin-1")).get("key")
    return given[-1] if given else None
