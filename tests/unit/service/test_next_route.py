"""Next shots: what may be asked, and that the job gets the question and the rig's limits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rigctl.config import load
from rigctl.jobs import Jobs
from rigctl.service.routes import model as routes_model
from rigctl.store import Change, ShotState, Store

WAIT_S = 120.0
NEXT = "/api/v1/campaigns/nylon/next"


@pytest.fixture(autouse=True)
def stand_in(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    monkeypatch.setattr(routes_model, "FUNCTIONS", "stand_in_model")


@pytest.fixture(autouse=True)
def measured(store: Store, shoot: Callable[..., str]) -> None:
    """Fire a shot and have it measured."""
    shot = shoot("nylon")
    store.move(shot, ShotState.ANALYSING)
    number = store.folders.add_result(shot, {"status": "measured"})
    store.move(shot, ShotState.ANALYSED, Change(results=number))


@pytest.mark.parametrize(
    "order",
    [
        {},
        {"between": ["drag", "none"]},
        {"between": ["drag", "wind"], "probability": 0.95, "with": ["adhesion"]},
        {"sharpen": "mu", "to": 0.001},
        {"sharpen": "drag.Cd", "with": ["drag"]},
    ],
)
def test_the_job_gets_the_question_and_the_limits_of_the_rig(
    ask: Any, jobs: Jobs, order: dict[str, Any]
) -> None:
    accepted = ask("POST", NEXT, json=order)
    assert accepted.status_code == 202, accepted.text
    assert accepted.json()["kind"] == "next"
    jobs.wait(accepted.json()["job"], WAIT_S)
    asked = ask("GET", accepted.headers["location"]).json()["result"]
    absent: dict[str, Any] = {
        "between": None,
        "sharpen": None,
        "to": None,
        "probability": 0.9,
        "with": [],
    }
    limits = load().limits
    expected = absent | order | {"limits": [[*limits.pressure_kpa], [*limits.offset_mm]]}
    assert asked == expected


@pytest.mark.parametrize(
    ("order", "field"),
    [
        ({"between": ["drag"]}, "between"),
        ({"between": "drag"}, "between"),
        ({"between": ["drag", "drag"]}, "twice"),
        ({"between": ["drag", "wind"], "sharpen": "e"}, "between"),
        ({"to": 0.1}, "to"),
        ({"sharpen": "e", "to": 0}, "to"),
        ({"sharpen": "e", "to": True}, "to"),
        ({"probability": 1.0}, "probability"),
        ({"betwen": ["drag", "wind"]}, "betwen"),
    ],
)
def test_a_question_that_cannot_be_is_refused(
    ask: Any, jobs: Jobs, order: dict[str, Any], field: str
) -> None:
    answer = ask("POST", NEXT, json=order)
    assert answer.status_code == 422
    assert field in answer.text
    assert jobs.jobs() == []


def test_an_effect_that_nobody_knows_is_not_found(ask: Any, jobs: Jobs) -> None:
    answer = ask("POST", NEXT, json={"between": ["drag", "no-such"]})
    assert (answer.status_code, answer.json()["code"]) == (404, "not-found")
    assert jobs.jobs() == []


def test_two_questions_are_two_jobs_and_the_same_one_is_one(ask: Any) -> None:
    first, other, again = (
        ask("POST", NEXT, json={"sharpen": name}).json()["job"] for name in ("e", "mu", "e")
    )
    assert first != other
    assert first == again
