"""The last panel of films and tables that were brought: they are measured one after another."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

from nicegui import ui

from rigctl.documents import Json
from rigctl.jobs import Job, in_process
from rigctl.page.desk import Desk
from rigctl.page.model.state import Question
from rigctl.page.own.brought import CAMPAIGN, FIGURE, MEASURED, RESULT, Brought
from rigctl.page.own.look import FUNCTIONS
from rigctl.page.own.measured import MeasuredFilms
from rigctl.page.parts.waiting import Waiting


class MeasuringPanel:
    """Measures films, or tables, in the background, and shows what came of each.

    Parameters
    ----------
    paths
        Of the films or tables.
    heading
        Of the panel, with the number of its step.
    """

    def __init__(self, desk: Desk, brought: Brought, paths: Sequence[Path], heading: str) -> None:
        self._desk, self._brought, self._paths = desk, brought, paths
        self._heading = heading
        self._now = 0
        self._stated: Json = {}
        self._remark: Callable[[Json], str | None] = _no_remark
        self._results = brought.results()
        self._failures: dict[int, str] = {}
        self._measure = Question(self._ask, desk.daemon.jobs.job)
        with ui.element("section").classes("panel").props("data-testid=own-result"):
            Waiting(desk, "Measuring", lambda: self._measure.running or "", "measuring")
            self._measured()

    def start(self, stated: Json, remark: Callable[[Json], str | None] | None = None) -> None:
        """Measure all afresh; what was measured before is removed.

        Parameters
        ----------
        stated
            Of the ball, the camera and the part: it holds for all, whatever is changed meanwhile.
        remark
            What else is to be said of a result; None: nothing.
        """
        self._stated, self._remark = stated, remark or _no_remark
        shutil.rmtree(self._brought.folder / MEASURED, ignore_errors=True)
        (self._brought.folder / MEASURED).mkdir()
        self._results, self._failures, self._now = {}, {}, 0
        self._measure.start()
        self._measured.refresh()

    def follow(self) -> None:
        """Show what has been measured since."""
        if self._measure.follow():
            self._keep()
            self._measured.refresh()

    def _keep(self) -> None:
        """Keep what came of a film, and go on with the next one unless a person ended it."""
        answer = self._measure.answer
        if answer is not None:
            self._results[self._now] = answer
            remark = self._remark(answer)
            answer["notes"] += [remark] if remark else []
        else:
            self._failures[self._now] = self._measure.failure
        if self._now + 1 < len(self._paths) and not self._measure.cancelled:
            self._now += 1
            self._measure.start()

    @ui.refreshable_method
    def _measured(self) -> None:
        ui.html(self._heading, sanitize=False, tag="h3").classes("card-heading")
        names = [path.name for path in self._paths]
        current = None if self._measure.running is None else self._now
        MeasuredFilms(
            self._desk, self._brought, names, self._results, self._failures, current
        ).place()

    def _ask(self) -> Job:
        folder, number = self._brought.folder / MEASURED, self._now
        asked = {
            "path": str(self._paths[number]),
            "shot": number + 1,
            "name": self._paths[number].name,
            "title": self._paths[0].name,
            **self._stated,
            "figure": str(folder / f"{FIGURE}-{number + 1}.png"),
            "result": str(folder / f"{RESULT}-{number + 1}.json"),
            "earlier": [str(folder / f"{RESULT}-{done + 1}.json") for done in self._results],
            "campaign": str(folder / CAMPAIGN),
        }
        work = in_process(f"{FUNCTIONS}:measure_job", asked)
        return self._desk.daemon.jobs.submit("film", self._paths[number].name, work)


def _no_remark(_: Json) -> str | None:
    return None
