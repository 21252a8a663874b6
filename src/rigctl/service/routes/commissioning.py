"""Commissioning: what must be seen of a real rig before it fires."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request

from rigctl.daemon import Daemon
from rigctl.service.commissioning_models import (
    AnswerOrder,
    CommissioningView,
    FoundView,
    RewiredOrder,
    StepView,
)
from rigctl.service.guards.bodies import StrictRoute
from rigctl.service.lanes import Lanes
from rigctl.service.problems import documented


def commissioning_routes(daemon: Daemon, lanes: Lanes) -> APIRouter:
    """Return the routes below `/rig/commissioning`."""
    router = APIRouter(prefix="/rig/commissioning", tags=["rig"], route_class=StrictRoute)

    @router.get("", responses=documented(401, 405, 503))
    def steps() -> CommissioningView:
        """List every step, and say which are asked for and why."""
        return view(daemon)

    @router.get("/record", responses=documented(401, 405, 503))
    def record() -> dict[str, Any]:
        """Return the signed record: steps, dates, people, hashes of configuration and firmware."""
        return daemon.commissioning.record()

    @router.post("/rewired", responses=documented(401, 404, 405, 411, 413, 422, 503))
    async def rewired(order: RewiredOrder, request: Request) -> CommissioningView:
        """Ask for the steps of a part again, after work on its wiring, boards or firmware."""
        who = request.state.actor
        await lanes.control(
            lambda: daemon.commissioning.rewired(
                order.part, people=order.people, note=order.note, actor=who
            )
        )
        return await lanes.control(lambda: view(daemon))

    @router.post("/{step}/act", responses=documented(401, 404, 405, 409, 422, 503))
    async def act(step: str, request: Request) -> FoundView:
        """Do what the daemon has to do for a step; it may stop, move or fire the rig."""
        who = request.state.actor
        found = await lanes.control(lambda: daemon.commissioning.act(step, who))
        return FoundView.showing(found)

    @router.post("/{step}/answer", responses=documented(401, 404, 405, 409, 411, 413, 422, 503))
    async def answer(step: str, order: AnswerOrder, request: Request) -> StepView:
        """Say whether a step was as it must be; signed and kept in the audit."""
        who = request.state.actor
        standing = await lanes.control(
            lambda: daemon.commissioning.answer(
                step, seen=order.seen, people=order.people, note=order.note or "", actor=who
            )
        )
        return StepView.of(standing, None)

    return router


def view(daemon: Daemon) -> CommissioningView:
    """Return the steps as they stand."""
    walk = daemon.commissioning
    steps = [StepView.of(each, walk.found(each.step.name)) for each in walk.standings()]
    missing = [step.name for step in steps if step.missing]
    return CommissioningView(
        complete=not missing,
        needed=daemon.configuration.simulation is None,
        next=missing[0] if missing else None,
        steps=steps,
    )
