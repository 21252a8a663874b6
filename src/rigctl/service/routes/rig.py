"""The rig: its state, arming, the emergency stop and the way out of its latch."""

from __future__ import annotations

from contextlib import suppress

import anyio
from fastapi import APIRouter, Request
from starlette.requests import ClientDisconnect

from rigctl.daemon import Daemon
from rigctl.service.guards.requests import StrictRoute
from rigctl.service.lanes import Lanes
from rigctl.service.models import ArmView, ReleaseOrder, RigView
from rigctl.service.problems import documented
from rigctl.service.stop_port import LONGEST_REASON, REASON_WAIT_S, reason_of
from rigctl.settings import ShotSettings

_REASON_BODY = {
    "requestBody": {
        "required": False,
        "content": {"application/json": {"schema": ReleaseOrder.model_json_schema()}},
    }
}


def rig_routes(daemon: Daemon, lanes: Lanes) -> APIRouter:
    """Return the routes below `/rig`."""
    router = APIRouter(prefix="/rig", tags=["rig"], route_class=StrictRoute)
    rig = daemon.rig

    @router.get("", responses=documented(401, 405, 503))
    def status() -> RigView:
        """Show state, settings and interlocks, and whether the rig is simulated."""
        return RigView.of(rig.status())

    @router.post("/arm", responses=documented(401, 405, 409, 411, 413, 422, 503))
    async def arm(settings: ShotSettings, request: Request) -> ArmView:
        """Set pressure and offset, wait until they settle, check every interlock.

        The token fires once, with these settings, until it expires.
        """
        armed = await lanes.control(lambda: rig.arm(settings, request.state.actor))
        return ArmView(
            arm_token=armed.token,
            expires_at=armed.expires_at,
            expires_in_s=armed.expires_in_s,
            warnings=list(armed.warnings),
        )

    @router.post("/estop", responses=documented(405, 503), openapi_extra=_REASON_BODY)
    async def estop(request: Request) -> RigView:
        """Cut the power of every actuator and latch.

        Needs no key, waits for no other call, and is never refused for the form of its body: a
        reason that cannot be read at once is left out.
        """
        reason = await _reason(request)
        await lanes.stop(lambda: rig.estop(request.state.actor, reason))
        return RigView.of(await lanes.stop(rig.status))

    @router.post("/release", responses=documented(401, 405, 409, 411, 413, 422, 503))
    async def release(order: ReleaseOrder, request: Request) -> RigView:
        """Leave the latch, a fault or an unknown outcome, after a person has looked."""
        await lanes.control(lambda: rig.release(request.state.actor, order.reason))
        return RigView.of(await lanes.control(rig.status))

    return router


async def _reason(request: Request) -> str:
    body = b""
    with anyio.move_on_after(REASON_WAIT_S), suppress(ClientDisconnect):
        async for piece in request.stream():
            body += piece
            if len(body) > LONGEST_REASON:
                break
    return reason_of(body)
