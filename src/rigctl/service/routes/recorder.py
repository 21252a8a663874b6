"""The tape recorder's keypad."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from rigctl.cameras.keypad import Keypad
from rigctl.daemon import Daemon
from rigctl.errors import NotFoundError
from rigctl.rig.tape import erase_tape
from rigctl.service.guards.bodies import StrictRoute
from rigctl.service.lanes import Lanes
from rigctl.service.pictures import png
from rigctl.service.problems import documented
from rigctl.service.recorder_models import KeyOrder, RecorderView


def recorder_routes(daemon: Daemon, lanes: Lanes) -> APIRouter:
    """Return the routes below `/rig/recorder`."""
    router = APIRouter(prefix="/rig/recorder", tags=["rig"], route_class=StrictRoute)

    @router.get("", responses=documented(401, 404, 405, 409, 503))
    async def status() -> RecorderView:
        """Show mode, tape, session, picture and marks; refused while a shot is under way."""
        keypad = require_keypad(daemon)
        return await lanes.control(lambda: RecorderView.of(keypad))

    @router.post("", responses=documented(401, 404, 405, 409, 411, 413, 422, 503))
    async def press(order: KeyOrder, request: Request) -> RecorderView:
        """Press one key; refused while a shot is under way. What is erased stands in the audit."""
        keypad, who = require_keypad(daemon), request.state.actor
        await lanes.control(lambda: pressed(daemon, keypad, order, who))
        return await lanes.control(lambda: RecorderView.of(keypad))

    @router.get(
        "/picture.png",
        response_class=Response,
        responses={
            200: {"content": {"image/png": {"schema": {"type": "string", "format": "binary"}}}},
            **documented(401, 404, 405, 409, 500, 503),
        },
    )
    async def picture() -> Response:
        """Stop playback and show the picture on which it stands, as PNG."""
        keypad = require_keypad(daemon)
        frames = await lanes.control(keypad.still)
        return Response(png(frames.pixels[0]), media_type="image/png")

    return router


def require_keypad(daemon: Daemon) -> Keypad:
    """Return the keypad of the rig's recorder; raise `NotFoundError` where it has none."""
    if daemon.keypad is None:
        raise NotFoundError(
            "this rig's camera is no tape recorder", part="camera", todo="use the camera's own page"
        )
    return daemon.keypad


def pressed(daemon: Daemon, keypad: Keypad, order: KeyOrder, actor: str) -> None:
    """Press a key; what it has erased stands in the audit."""
    if order.key == "erase":
        erase_tape(keypad, daemon.store, actor)
    else:
        order.press(keypad)
