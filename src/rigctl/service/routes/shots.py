"""Shots: fire one, list them, look at frames and measurements."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Header, Path, Query, Request
from starlette.responses import Response

from rigctl.daemon import Daemon
from rigctl.errors import NotFoundError
from rigctl.service.guards.requests import StrictRoute
from rigctl.service.lanes import Lanes
from rigctl.service.models import (
    FrameQuery,
    ShotAccepted,
    ShotList,
    ShotOrder,
    ShotQuery,
    ShotView,
)
from rigctl.service.pictures import frame_of, overlaid, png
from rigctl.service.problems import documented

IdempotencyKey = Annotated[
    str,
    Header(
        alias="Idempotency-Key",
        pattern=r"^[\x21-\x7e]{1,200}$",
        description="chosen by the caller, fresh for each shot",
    ),
]
FrameNumber = Annotated[int, Path(ge=0, le=1_000_000, description="counted from 0")]


def shot_routes(daemon: Daemon, lanes: Lanes) -> APIRouter:
    """Return the routes below `/shots`."""
    router = APIRouter(prefix="/shots", tags=["shots"], route_class=StrictRoute)
    store = daemon.store

    @router.post("", status_code=202, responses=documented(400, 401, 405, 409, 411, 413, 422, 503))
    async def fire(
        order: ShotOrder, key: IdempotencyKey, request: Request, response: Response
    ) -> ShotAccepted:
        """Fire once.

        The same key again gives the stored answer and fires nothing; with another body it is 422,
        and 409 while its shot is under way.
        """
        record = await lanes.fire(
            lambda: daemon.rig.accept(
                token=order.arm_token,
                key=key,
                body_hash=order.digest(),
                campaign=order.campaign,
                note=order.note,
                actor=request.state.actor,
            )
        )
        response.headers["Location"] = f"{request.url.path}/{record.id}"
        return ShotAccepted(shot=record.id, state=record.outcome or record.state)

    @router.get("", responses=documented(401, 404, 405, 422, 503))
    def shots(query: Annotated[ShotQuery, Query()]) -> ShotList:
        """List shots, oldest first, page by page."""
        # One more than requested shows whether a further page exists.
        found = store.shots(
            campaign=query.campaign,
            state=query.state,
            excluded=query.excluded,
            tag=query.tag,
            limit=query.limit + 1,
            after=query.after,
        )
        page = found[: query.limit]
        return ShotList(
            shots=[ShotView.of(record) for record in page],
            next=page[-1].id if len(found) > query.limit else None,
        )

    @router.get("/{shot}", responses=documented(401, 404, 405, 422, 503))
    def shot(shot: str) -> ShotView:
        """Show one shot."""
        return ShotView.of(store.shot(shot))

    @router.get(
        "/{shot}/frames/{number}.png",
        response_class=Response,
        responses={
            200: {"content": {"image/png": {"schema": {"type": "string", "format": "binary"}}}},
            **documented(401, 404, 405, 422, 500, 503),
        },
    )
    def frame(shot: str, number: FrameNumber, query: Annotated[FrameQuery, Query()]) -> Response:
        """Show one frame as PNG; with `overlay=outlines` what the analysis found is drawn in."""
        store.shot(shot)
        picture = frame_of(store.frames(shot).pixels, number, shot)
        if query.overlay == "outlines":
            picture = overlaid(picture, _latest(daemon, shot), number)
        return Response(png(picture), media_type="image/png")

    @router.get("/{shot}/result", responses=documented(401, 404, 405, 422, 503))
    def result(shot: str) -> dict[str, Any]:
        """Show the latest measurement of a shot; 404 while there is none."""
        store.shot(shot)
        return store.result(shot)

    return router


def _latest(daemon: Daemon, shot: str) -> dict[str, Any]:
    try:
        return daemon.store.result(shot)
    except NotFoundError:
        return {}
