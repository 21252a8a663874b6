"""A service that is reached through a reverse proxy, and through nothing else."""

from __future__ import annotations

from typing import Any, cast

from starlette.types import ASGIApp, Receive, Scope, Send
from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

from rigctl.service.guards.auth import ESTOP_PATH, address_of
from rigctl.service.problems import Problem, answer


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
