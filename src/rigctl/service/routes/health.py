"""Whether the daemon lives, and whether the rig could take a shot."""

from __future__ import annotations

from typing import Literal

from fastapi import APIRouter
from pydantic import BaseModel
from starlette.responses import Response

from rigctl.access.wrong_keys import WrongKeys
from rigctl.daemon import Daemon
from rigctl.rig.states import LATCHED
from rigctl.service.problems import Problem, answer, documented


class Live(BaseModel):
    """The process answers."""

    status: Literal["live"] = "live"


class Ready(BaseModel):
    """The rig takes orders; the counts are of shots that the last start found unfinished.

    `wrong_keys` counts the requests since then that came with a key that opens nothing.
    """

    status: Literal["ready"] = "ready"
    simulated: bool
    interrupted: int
    unknown_outcome: int
    completed: int
    wrong_keys: int


def health_routes(daemon: Daemon, wrong: WrongKeys) -> APIRouter:
    """Return the routes below `/health`; they need no key."""
    router = APIRouter(prefix="/health", tags=["health"])

    @router.get("/live", responses=documented(405))
    def live() -> Live:
        """Answer as long as the process does."""
        return Live()

    @router.get("/ready", response_model=Ready, responses=documented(405, 503))
    def ready() -> Ready | Response:
        """Show whether the rig takes orders; 503 names what a person must do first."""
        status = daemon.rig.status()
        if status.state not in LATCHED:
            found = daemon.recovery
            return Ready(
                simulated=status.simulated,
                interrupted=len(found.interrupted),
                unknown_outcome=len(found.unknown),
                completed=len(found.completed),
                wrong_keys=wrong.count,
            )
        return answer(
            Problem(
                status=503,
                code="not-ready",
                title="The rig waits for a person",
                detail=f"the rig is {status.state}: {status.latch_reason or status.reason}",
                field="rig",
                value=status.state,
                todo="look at the rig, then POST /api/v1/rig/release with a reason",
            )
        )

    return router
