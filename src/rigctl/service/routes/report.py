"""The report of a campaign: a job makes it, and the same request then returns the HTML page."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from fastapi import APIRouter
from starlette.responses import Response

from rigctl.daemon import Daemon
from rigctl.jobs import Job, JobState, in_process
from rigctl.measuring.measured import MOST_SHOTS, measured_files
from rigctl.plain_text import CampaignName
from rigctl.service.accepted import accepted, accepts
from rigctl.service.problems import documented

FUNCTION = "rigctl.reports.campaign:report_job"
ALONE = {
    "Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; img-src data:",
    "X-Content-Type-Options": "nosniff",
}
"""The page loads nothing and runs nothing."""

_PAGE: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "The report, for the shots as they are measured now",
        "content": {"text/html": {"schema": {"type": "string"}}},
    }
}


def report_of(daemon: Daemon, campaign: str) -> Job:
    """Return the job that reports a campaign as its shots stand now; its result has `html`.

    Raises
    ------
    NotFoundError
        There is no such campaign, or none of its shots is measured and counts.
    JobsFullError
        Too many jobs wait.
    """
    measured_files(daemon.store, campaign)
    store = daemon.store
    asked = {"store": str(store.path), "database": store.address, "campaign": campaign}
    named = ("report", campaign, _as_they_are(daemon, campaign))
    return daemon.jobs.submit("report", campaign, in_process(FUNCTION, asked), named)


def report_routes(daemon: Daemon) -> APIRouter:
    """Return the route of reports."""
    router = APIRouter(prefix="/campaigns/{campaign}", tags=["campaigns"])

    @router.get(
        "/report",
        responses=_PAGE | accepts() | documented(401, 404, 405, 409, 422, 503),
        response_class=Response,
    )
    def report(campaign: CampaignName) -> Response:
        """Give the results of a campaign as one HTML file.

        202 with a job until it is made; the same request then returns the page.
        """
        job = report_of(daemon, campaign)
        if job.state is not JobState.DONE or job.result is None:
            return accepted(job)
        return Response(json.loads(job.result)["html"], media_type="text/html", headers=ALONE)

    return router


def _as_they_are(daemon: Daemon, campaign: str) -> str:
    """Return a digest of a campaign's shots in the catalogue."""
    digest = hashlib.sha256()
    for shot in daemon.store.shots(campaign=campaign, limit=MOST_SHOTS):
        digest.update(repr(shot).encode())
    return digest.hexdigest()
