"""What leaves a campaign: its report as one page of HTML, and its shots as an exchange folder."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from fastapi import FastAPI
from nicegui import ui
from starlette.responses import Response

from rigctl.errors import RigError
from rigctl.exchange import export_campaign
from rigctl.jobs import Job, Task
from rigctl.page.desk import Desk
from rigctl.page.layout import TICK_S
from rigctl.page.model.state import Question
from rigctl.page.parts.following import following
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button
from rigctl.service.problems import answer, from_error
from rigctl.service.routes.report import ALONE, report_of

EXPORTS = "exports"
"""Folder of what is exported here, inside the store's, unless another one is named."""


def report_route(app: FastAPI, desk: Desk) -> None:
    """Register the route of finished reports, beside the pages."""

    @app.get("/reports/{job}.html", include_in_schema=False)
    def report(job: str) -> Response:
        try:
            found = desk.daemon.jobs.job(job)
        except RigError as error:
            return answer(from_error(error))
        html = json.loads(found.result or "{}").get("html", "")
        return Response(html, media_type="text/html", headers=ALONE)


class Output:
    """Two buttons, and what came of them."""

    def __init__(self, desk: Desk, campaign: str) -> None:
        self._desk, self._campaign = desk, campaign
        self._job = ""
        jobs = desk.daemon.jobs
        self._report = Question(self._ask_report, jobs.job)
        self._export = Question(self._ask_export, jobs.job)
        self._folder = str(desk.daemon.store.path / EXPORTS / campaign)
        with ui.element("div").classes("beside"):
            self._show()
            report = button("Report", self._write_report, testid="report")
            report.tooltip("results, figures and how to reproduce them, as one file to keep")
            export = button("Export …", self._ask_folder, testid="export")
            export.tooltip("tables and frames as a folder that other programs read")
            self._buttons = ((self._report, report), (self._export, export))
        Waiting(desk, "Writing the report", lambda: self._report.running or "", "reporting")
        Waiting(desk, "Writing the folder", lambda: self._export.running or "", "exporting")
        following(TICK_S * 3, self._follow)

    def _follow(self) -> None:
        if self._report.follow() | self._export.follow():
            self._draw()

    @ui.refreshable_method
    def _show(self) -> None:
        for asked in (self._report, self._export):
            if asked.failure:
                ui.label(asked.failure).classes("note fails")
        if self._report.answer is not None:
            address = f"/reports/{self._job}.html"
            ui.link("open the report", address, new_tab=True).props("data-testid=report-link")
        if self._export.answer is not None:
            said = f"{self._export.answer['shots']} shots in {self._export.answer['folder']}"
            ui.label(said).classes("note").props("data-testid=exported")

    def _draw(self) -> None:
        """Draw what came of it; the buttons stay, and so does a click on one of them."""
        self._show.refresh()
        for asked, placed in self._buttons:
            placed.set_enabled(asked.running is None)

    def _write_report(self) -> None:
        self._start(self._report)

    def _start(self, asked: Question) -> None:
        asked.start()
        self._draw()

    def _ask_report(self) -> Job:
        job = report_of(self._desk.daemon, self._campaign)
        self._job = job.id
        return job

    def _ask_export(self) -> Job:
        store, folder = self._desk.daemon.store, Path(self._folder).expanduser().absolute()

        def work(task: Task) -> str:
            folder.parent.mkdir(parents=True, exist_ok=True)
            written = export_campaign(store, self._campaign, folder, progress=task.progress)
            return json.dumps({**asdict(written), "folder": str(written.folder)})

        return self._desk.daemon.jobs.submit("export", self._campaign, work)

    def _ask_folder(self) -> None:
        def go() -> None:
            self._folder = str(path.value).strip()
            dialog.close()
            self._start(self._export)

        with ui.dialog(value=True) as dialog, ui.card().classes("ask"):
            ui.label(f"Export {self._campaign}").classes("title")
            ui.label("A folder on the daemon's host that is not there yet.")
            path = ui.input("Folder", value=self._folder).classes("wide")
            path.props("autofocus outlined data-testid=export-folder")
            with ui.element("div").classes("beside ends"):
                button("Cancel", dialog.close)
                written = button("Export", go, look="fill", testid="export-now")
                written.bind_enabled_from(path, "value", lambda text: bool((text or "").strip()))
        dialog.on("hide", dialog.delete)
