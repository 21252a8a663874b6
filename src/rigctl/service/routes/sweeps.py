"""Sweeps: start one, watch it, pause it, let it go on, give it up."""

from __future__ import annotations

import hashlib
from typing import Annotated

from fastapi import APIRouter, Path, Query, Request, Response

from rigctl.daemon import Daemon
from rigctl.service.guards.requests import StrictRoute
from rigctl.service.lanes import Lanes
from rigctl.service.problems import documented
from rigctl.service.routes.shots import IdempotencyKey
from rigctl.service.sweep_models import SweepList, SweepQuery, SweepTable, SweepView
from rigctl.sweeps.form import Sweep
from rigctl.sweeps.plan import plan_of

SweepName = Annotated[str, Path(pattern=r"^\d{8}-s\d{4,12}$")]


def sweep_routes(daemon: Daemon, lanes: Lanes) -> APIRouter:
    """Return the routes below `/sweeps`."""
    router = APIRouter(prefix="/sweeps", tags=["sweeps"], route_class=StrictRoute)
    refusals = documented(401, 404, 405, 409, 422, 503)

    @router.post("", status_code=202, responses=documented(400, 401, 405, 409, 411, 413, 422, 503))
    async def start(
        form: Sweep, key: IdempotencyKey, request: Request, response: Response
    ) -> SweepView:
        """Put a sweep on disk with all its steps, and run it.

        The same key again gives the sweep as it stands and starts nothing; with another body it
        is 422.
        """
        digest = hashlib.sha256(form.model_dump_json().encode()).hexdigest()
        status = await lanes.control(
            lambda: daemon.sweeps.start(plan_of(form), key, digest, request.state.actor)
        )
        response.headers["Location"] = f"{request.url.path}/{status.record.id}"
        return SweepView.of(status)

    @router.get("", responses=documented(401, 404, 405, 422, 503))
    def sweeps(query: Annotated[SweepQuery, Query()]) -> SweepList:
        """List sweeps, latest first, page by page."""
        # One more than requested shows whether a further page exists.
        found = daemon.store.sweeps.sweeps(
            state=query.state, limit=query.limit + 1, before=query.before
        )
        page = found[: query.limit]
        return SweepList(
            sweeps=[SweepView.of(daemon.sweeps.status(record.id)) for record in page],
            next=page[-1].id if len(found) > query.limit else None,
        )

    @router.get("/{sweep}", responses=documented(401, 404, 405, 422, 503))
    def sweep(sweep: SweepName) -> SweepView:
        """Show one sweep: how far it is, and how long it will take."""
        return SweepView.of(daemon.sweeps.status(sweep))

    @router.get("/{sweep}/steps", responses=documented(401, 404, 405, 422, 503))
    def steps(sweep: SweepName) -> SweepTable:
        """Show the request, and the outcome of each step."""
        found = daemon.store.sweeps
        return SweepTable.of(found.sweep(sweep), found.steps(sweep))

    @router.post("/{sweep}/pause", responses=refusals)
    async def pause(sweep: SweepName, request: Request) -> SweepView:
        """Fire nothing more until it is resumed; a shot under way still ends."""
        actor = request.state.actor
        return SweepView.of(await lanes.control(lambda: daemon.sweeps.pause(sweep, actor)))

    @router.post("/{sweep}/resume", responses=refusals)
    async def resume(sweep: SweepName, request: Request) -> SweepView:
        """Go on at the next step that has not fired."""
        actor = request.state.actor
        return SweepView.of(await lanes.control(lambda: daemon.sweeps.resume(sweep, actor)))

    @router.post("/{sweep}/abort", responses=refusals)
    async def abort(sweep: SweepName, request: Request) -> SweepView:
        """Give it up; a shot under way still ends, and nothing stays armed."""
        actor = request.state.actor
        return SweepView.of(await lanes.control(lambda: daemon.sweeps.abort(sweep, actor)))

    return router
