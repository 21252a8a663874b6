"""The answer of a route whose work takes long: 202 with the job that does it."""

from __future__ import annotations

from typing import Any

from starlette.responses import Response

from rigctl.jobs import Job, JobState
from rigctl.service.guards.auth import PREFIX
from rigctl.service.job_models import JobSummary


def accepted(job: Job) -> Response:
    """Return 202 with a job; `Location` is where its progress and result are found."""
    return Response(
        JobSummary.of(job).model_dump_json(),
        status_code=202,
        media_type="application/json",
        headers={"Location": f"{PREFIX}/jobs/{job.id}"},
    )


def answered(job: Job) -> Response:
    """Return the result of a job that is done, which is JSON; 202 with the job before."""
    if job.state is JobState.DONE:
        return Response(job.result, media_type="application/json")
    return accepted(job)


def accepts() -> dict[int | str, dict[str, Any]]:
    """Return the OpenAPI entry of that answer."""
    location = {"description": "the job", "schema": {"type": "string"}}
    return {
        202: {
            "description": "A job does the work",
            "model": JobSummary,
            "headers": {"Location": location},
        }
    }
