"""Commissioning over REST: what must be seen of a real rig before it fires."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Self

from fastapi import APIRouter, Request
from pydantic import BaseModel, Field

from rigctl.commissioning.gate import Standing
from rigctl.commissioning.step import Act, Part
from rigctl.commissioning.walk import Found
from rigctl.config.model import StrictModel
from rigctl.daemon import Daemon
from rigctl.plain_text import Line
from rigctl.service.forms import View
from rigctl.service.guards.requests import StrictRoute
from rigctl.service.lanes import Lanes
from rigctl.service.problems import documented

MOST_PEOPLE = 16
People = Annotated[list[Line], Field(min_length=1, max_length=MOST_PEOPLE)]
"""Who has looked."""


class AnswerOrder(StrictModel):
    """Whether a step was as it must be; a no needs a note of what was seen instead."""

    seen: bool
    people: People
    note: Line | None = None


class RewiredOrder(StrictModel):
    """A part whose wiring, board or firmware was worked on: its steps are asked for again."""

    part: Annotated[Part, Field(strict=False)]
    people: People
    note: Line


class FoundView(View):
    """What the daemon saw of its act: `holds` when it was what the step needs."""

    holds: bool
    text: str


class StepView(View):
    """One step. `missing` says why it is asked for, and is empty once it was seen."""

    name: str
    part: Part
    title: str
    do: str
    see: str
    act: Act | None
    missing: str
    answer: str | None
    answered_at: datetime | None
    people: list[str]
    note: str | None
    found: FoundView | None = Field(description="what the daemon saw since the last answer")

    @classmethod
    def of(cls, standing: Standing, found: Found | None) -> Self:
        """Return a step as REST shows it."""
        said = standing.answer
        return cls.showing(
            standing.step,
            missing=standing.missing,
            answer=None if said is None else said.answer,
            answered_at=None if said is None else datetime.fromisoformat(said.at),
            people=[] if said is None else list(said.people),
            note=None if said is None else said.note or None,
            found=None if found is None else FoundView.showing(found),
        )


class CommissioningView(BaseModel):
    """All steps in order. A real rig fires nothing while `complete` is false."""

    complete: bool
    needed: bool = Field(description="whether this rig must be commissioned: a real one must")
    next: str | None = Field(description="the first step that is asked for")
    steps: list[StepView]


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
