"""Long work in the background: queued, watched, cancelled, and its result kept for a while."""

from rigctl.jobs.failure import JobFailedError
from rigctl.jobs.job import ENDED, Job, JobState
from rigctl.jobs.process import in_process
from rigctl.jobs.runner import Jobs
from rigctl.jobs.task import Task, Work

__all__ = ["ENDED", "Job", "JobFailedError", "JobState", "Jobs", "Task", "Work", "in_process"]
