"""The report by REST: a job at first, then a page, until a shot changes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rigctl.jobs import Jobs
from rigctl.service.routes import report as routes_report
from rigctl.store import Change, ShotState, Store

Shoot = Callable[..., str]
WAIT_S = 120.0
REPORT = "/api/v1/campaigns/nylon/report"


@pytest.fixture(autouse=True)
def stand_in(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    monkeypatch.setattr(routes_report, "FUNCTION", "stand_in_report:report_job")


@pytest.fixture
def measured(store: Store, shoot: Shoot) -> str:
    shot = shoot("nylon")
    store.move(shot, ShotState.ANALYSING)
    number = store.folders.add_result(shot, {"status": "measured"})
    store.move(shot, ShotState.ANALYSED, Change(results=number))
    return shot


@pytest.mark.usefixtures("measured")
def test_a_report_is_made_by_a_job_and_asked_again_is_a_page(ask: Any, jobs: Jobs) -> None:
    first = ask("GET", REPORT)
    assert (first.status_code, first.json()["kind"]) == (202, "report")
    jobs.wait(first.json()["job"], WAIT_S)
    page = ask("GET", REPORT)
    assert (page.status_code, page.text) == (200, "<p>nylon</p>")
    assert page.headers["content-type"].startswith("text/html")
    assert page.headers["content-security-policy"].startswith("default-src 'none'")


def test_a_shot_that_changes_makes_the_report_anew(
    ask: Any, jobs: Jobs, store: Store, shoot: Shoot, measured: str
) -> None:
    jobs.wait(ask("GET", REPORT).json()["job"], WAIT_S)
    assert ask("GET", REPORT).status_code == 200
    refused = shoot("nylon")
    second = ask("GET", REPORT)
    assert second.status_code == 202
    store.move(refused, ShotState.ANALYSING)
    store.move(refused, ShotState.REFUSED)
    assert ask("GET", REPORT).json()["job"] != second.json()["job"]
    assert measured


def test_a_campaign_without_a_measured_shot_has_no_report(ask: Any, shoot: Shoot) -> None:
    assert ask("GET", REPORT).status_code == 404
    shoot("nylon")
    assert ask("GET", REPORT).json()["code"] == "not-found"
