"""The front page at the address that `rigctl serve` prints."""

from __future__ import annotations

from importlib.metadata import version

from fastapi import APIRouter
from starlette.responses import PlainTextResponse

from rigctl.daemon import Daemon
from rigctl.service.guards.auth import PREFIX


def front_route(daemon: Daemon) -> APIRouter:
    """Return the route of `/`: name of the rig and links to its interfaces. Needs no key."""
    router = APIRouter()
    configuration = daemon.configuration
    kind = "real" if configuration.simulation is None else "simulated"
    text = (
        f"rigctl {version('rigctl')}: rig {configuration.name!r}, {kind}.\n"
        f"REST below {PREFIX} with the header 'Authorization: Bearer KEY', where KEY is what\n"
        "follows ?key= in this page's address; described in full at /openapi.json.\n"
    )

    @router.get("/", include_in_schema=False)
    def front() -> PlainTextResponse:
        return PlainTextResponse(text)

    return router
