"""Who may ask this service and frame its pages: its own sites, and its proxy where it has one."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Iterable, Mapping
from typing import Any, cast
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

from rigctl.service.guards.auth import ESTOP_PATH, address_of
from rigctl.service.problems import Problem, answer

_OWN_SITE = frozenset({"same-origin", "none"})


class OwnOrigins:
    """Checks that a request comes from our own page, or from a program that is no browser.

    A browser states in `Host` the name it was given, and in `Origin` and `Sec-Fetch-Site` whose
    page asks. Programs without a browser state neither, and are let through.

    Parameters
    ----------
    names
        Names under which the service is reached, without port, beside `localhost` and the host's
        own name. An IP address is always accepted: no foreign name can be made to mean it.
    """

    def __init__(self, names: Iterable[str] = ()) -> None:
        self._names = {"localhost", socket.gethostname().lower(), *(n.lower() for n in names)}

    def refusal(self, headers: Mapping[str, str]) -> Problem | None:
        """Return why a request with these headers (names in lower case) is foreign, or None."""
        host = headers.get("host")
        if host is not None and not self._is_ours(host):
            return _foreign("Host", host, "a name that the setting service.names lists")
        origin = headers.get("origin")
        if origin is not None and (host is None or urlsplit(origin).netloc != host):
            return _foreign("Origin", origin, f"the page at {host}")
        site = headers.get("sec-fetch-site")
        if site is not None and site not in _OWN_SITE:
            return _foreign("Sec-Fetch-Site", site, " or ".join(sorted(_OWN_SITE)))
        return None

    def _is_ours(self, host: str) -> bool:
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        return name in self._names or _is_address(name)


class OriginGuard:
    """Answers 403 to foreign requests and closes foreign sockets, before anything else."""

    def __init__(self, app: ASGIApp, origins: OwnOrigins) -> None:
        self._app, self._origins = app, origins

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse, or pass the request on."""
        if scope["type"] in {"http", "websocket"}:
            refusal = self._origins.refusal(Headers(scope=scope))
            if refusal is not None:
                if scope["type"] == "websocket":
                    await send({"type": "websocket.close", "code": 4403})
                else:
                    await answer(refusal)(scope, receive, send)
                return
        await self._app(scope, receive, send)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _foreign(field: str, value: str, limit: str) -> Problem:
    shown = value[:80]
    return Problem(
        status=403,
        code="foreign-origin",
        title="The request comes from another site",
        detail=f"the header {field} is {shown!r}; {limit} is allowed",
        field=field,
        value=shown,
        limit=limit,
        todo="open the address that `rigctl serve` printed, in a tab of its own",
    )


POLICY = "; ".join(
    (
        "default-src 'self'",
        # The page library writes its scripts and templates into the page and compiles them there.
        "script-src 'self' 'unsafe-inline' 'unsafe-eval'",
        "style-src 'self' 'unsafe-inline'",
        "img-src 'self' data: blob:",
        "font-src 'self' data:",
        "object-src 'none'",
        "base-uri 'self'",
        "form-action 'self'",
        "frame-ancestors 'none'",
    )
)

HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class AnswerHeaders:
    """Adds `HEADERS` to every HTTP answer."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, and add the headers to its answer."""

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers[name] = value
            await send(message)

        await self._app(scope, receive, with_headers if scope["type"] == "http" else send)


def behind_proxy(app: ASGIApp, proxy: str | None) -> ASGIApp:
    """Return the application, answered to the proxy alone where the configuration names one."""
    if proxy is None:
        return app
    # Uvicorn has types of its own for the same interface.
    behind = cast("ASGIApp", ProxyHeadersMiddleware(cast("Any", app), trusted_hosts=proxy))
    return _ProxyOnly(behind, proxy)


class _ProxyOnly:
    """Refuses connections that bypass the proxy: they are not encrypted.

    The emergency stop is open to every client, here as well.
    """

    def __init__(self, app: ASGIApp, proxy: str) -> None:
        self._app, self._proxy = app, proxy

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer 403, or pass the request on."""
        stops = scope["type"] == "http" and scope["path"] == ESTOP_PATH
        if stops or scope["type"] == "lifespan" or address_of(scope) == self._proxy:
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 4403})
        else:
            refusal = Problem(
                status=403,
                code="not-by-proxy",
                title="The service is reached through its proxy",
                detail="the request did not come from the proxy that the configuration names",
                field="service.proxy",
                value=address_of(scope),
                limit=self._proxy,
                todo="use the address of the proxy",
            )
            await answer(refusal)(scope, receive, send)
