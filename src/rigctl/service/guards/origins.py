"""Requests that another web page makes a browser send are refused, on every way into the daemon."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Iterable, Mapping
from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

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
