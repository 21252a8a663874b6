"""A wait of more than a second: the step, seconds gone and left, and a way out of it."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from rigctl.jobs import Job, Jobs, JobState
from rigctl.jobs.duration import Wait, wait_of
from rigctl.jobs.job import utc_now
from rigctl.page.desk import Desk
from rigctl.page.parts.following import following
from rigctl.page.parts.widgets import button

LOOK_S = 0.25
UNSAID_S = 1.0
"""A wait shorter than this is not spoken of."""


class Waiting:
    """Placed once, seen while the job that `look` returns runs longer than a second.

    Parameters
    ----------
    title
        What is waited for, as a sentence's subject: "Fitting the model".
    look
        Returns the name of the job that is waited for; empty for none.
    worded
        Puts a step into the words of the view.
    """

    def __init__(
        self,
        desk: Desk,
        title: str,
        look: Callable[[], str],
        testid: str = "waiting",
        worded: Callable[[str], str] = str,
    ) -> None:
        self._desk, self._title, self._look, self._worded = desk, title, look, worded
        with ui.element("div").classes("waiting").props(f"data-testid={testid}") as self._all:
            with ui.element("div").classes("beside"):
                self._said = ui.label().classes("strong").props("role=status")
                ui.space()
                self._cancel = button("Cancel", self._on_cancel, testid="cancel-job")
                self._cancel.tooltip("ends this work at once; whatever was finished is kept")
            self._bar = ui.linear_progress(0.0, show_value=False, size="8px").props("rounded")
            self._bar.props(f'aria-label="{title}"')
            self._left = ui.label().classes("note")
        self._all.set_visibility(False)
        following(LOOK_S, self.show)

    def show(self) -> None:
        """Show how far the job is now."""
        jobs = self._desk.daemon.jobs
        job = _job(jobs, self._look())
        now = utc_now()
        seen = job is not None and (now - job.created_at).total_seconds() > UNSAID_S
        if seen != self._all.visible:
            self._all.set_visibility(seen)
        if job is None or not seen:
            return
        wait = wait_of(job, jobs.jobs(), now)
        self._said.set_text(f"{self._title}: {self._worded(step_of(job))}")
        self._left.set_text(said_of(wait))
        fill(self._bar, wait.share)

    async def _on_cancel(self) -> None:
        name = self._look()
        if name:
            self._said.set_text(f"{self._title}: is being cancelled")
            await self._desk.act(lambda: self._desk.daemon.jobs.cancel(name))
            self.show()


def fill(bar: ui.linear_progress, share: float | None) -> None:
    """Fill a bar to a share; where nobody can say one, it moves without end."""
    bar.props(
        add="indeterminate" if share is None else None,
        remove=None if share is None else "indeterminate",
    )
    # In steps of a hundredth: each change is sent to the browser.
    bar.set_value(round(share or 0.0, 2))


def step_of(job: Job) -> str:
    """Return the step under way in words."""
    if job.state is JobState.QUEUED:
        return "waits for other work to end"
    return job.progress or "starts"


def said_of(wait: Wait) -> str:
    """Say how long a wait lasts and how much of it is left, in whole seconds."""
    gone = f"{wait.gone_s:.0f} s gone"
    if wait.left_s is None:
        late = ", longer than usual" if wait.is_late else ""
        return f"{gone}{late}. You can go on reading."
    return f"{gone}, about {wait.left_s:.0f} s left. You can go on reading."


def cancelled_words(job: Job) -> str:
    """Say of a cancelled job where it was and what is kept."""
    at = f", while {job.progress}" if job.progress else ""
    took = (job.ended_at or job.created_at) - job.created_at
    return f"Cancelled after {took.total_seconds():.0f} s{at}. What was known before is kept."


def _job(jobs: Jobs, name: str) -> Job | None:
    return next((job for job in jobs.jobs() if job.id == name), None) if name else None
