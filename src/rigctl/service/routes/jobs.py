"""Jobs: how far they are, what came of them, and ending one."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path
from starlette.responses import Response

from rigctl.daemon import Daemon
from rigctl.jobs import Job
from rigctl.service.job_models import JobList, JobSummary, JobView, job_text
from rigctl.service.problems import documented

JobName = Annotated[str, Path(pattern=r"^[0-9a-f]{16}$")]


def job_routes(daemon: Daemon) -> APIRouter:
    """Return the routes below `/jobs`."""
    router = APIRouter(prefix="/jobs", tags=["jobs"])

    @router.get("", responses=documented(401, 405))
    def jobs() -> JobList:
        """List the jobs that are remembered, oldest first, without their results."""
        return JobList(jobs=[JobSummary.of(job) for job in daemon.jobs.jobs()])

    @router.get("/{job}", response_model=JobView, responses=documented(401, 404, 405, 422))
    def job(job: JobName) -> Response:
        """Show one job: how far it is and, once it is done, its result."""
        return _shown(daemon.jobs.job(job))

    @router.delete("/{job}", response_model=JobView, responses=documented(401, 404, 405, 422))
    def cancel(job: JobName) -> Response:
        """Cancel a job: its process is killed. One that has ended is left as it is."""
        return _shown(daemon.jobs.cancel(job))

    return router


def _shown(job: Job) -> Response:
    return Response(job_text(job), media_type="application/json")
