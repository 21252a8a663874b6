"""Jobs as REST shows them."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Self

from pydantic import BaseModel, Field

from rigctl.jobs import Job, JobState
from rigctl.service.forms import View


class JobSummary(View):
    """A job without its result. Times are UTC; what is not known is null."""

    job: str
    kind: str = Field(description="what is done, by the name of the route that asked for it")
    campaign: str
    state: JobState
    created_at: datetime
    started_at: datetime | None
    ended_at: datetime | None
    progress: str = Field(description="the step under way, in words")
    share: float | None = Field(description="the part done, from 0 to 1; null: nobody can say")
    enclosure: str = Field(
        description="what the process of its work is kept from, in words; empty: it has none"
    )
    failure: str | None
    failure_code: str | None

    @classmethod
    def of(cls, job: Job) -> Self:
        """Return a job as REST shows it."""
        return cls.showing(job, job=job.id, campaign=job.subject)


class JobView(JobSummary):
    """A job with its result, null until it is done."""

    result: dict[str, Any] | None = Field(
        description="of kind explain a `VerdictReport`, of kind fits a `FitReport` with its name "
        "and version, else as the route of the kind answers"
    )


def job_text(job: Job) -> str:
    """Return a `JobView` as JSON; the result, which is JSON already, goes in as it is."""
    summary = JobSummary.of(job).model_dump_json()
    return f'{summary.removesuffix("}")},"result":{job.result or "null"}}}'


class JobList(BaseModel):
    """The jobs that are remembered, oldest first."""

    jobs: list[JobSummary]
