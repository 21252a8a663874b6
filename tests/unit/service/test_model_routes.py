"""Questions about a campaign: a job at first, then the answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.model.proposals.stated import Statement
from rigctl.jobs import Jobs
from rigctl.service.campaign_models import StatedForm
from rigctl.service.routes import model as routes_model
from rigctl.store import Change, ShotState, Store

Shoot = Callable[..., str]
WAIT_S = 120.0
NYLON = "/api/v1/campaigns/nylon"
QUESTIONS = ["agreement", "structure", "ranking"]


@pytest.fixture(autouse=True)
def stand_in(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    monkeypatch.setattr(routes_model, "FUNCTIONS", "stand_in_model")


@pytest.fixture
def measure(store: Store, shoot: Shoot) -> Shoot:
    """Fire a shot and have it measured."""

    def fire(campaign: str = "nylon") -> str:
        shot = shoot(campaign)
        analyse(store, shot)
        return shot

    return fire


def analyse(store: Store, shot: str) -> None:
    store.move(shot, ShotState.ANALYSING)
    number = store.folders.add_result(shot, {"status": "measured"})
    store.move(shot, ShotState.ANALYSED, Change(results=number))


@pytest.mark.parametrize("question", QUESTIONS)
def test_a_question_is_answered_by_a_job_and_asked_again_by_its_result(
    ask: Any, jobs: Jobs, measure: Shoot, question: str
) -> None:
    measure()
    first = ask("GET", f"{NYLON}/{question}?with=drag&with=wind")
    assert first.status_code == 202
    assert (first.json()["kind"], first.json()["campaign"]) == (question, "nylon")
    job = ask("GET", first.headers["location"]).json()
    assert job["job"] == first.json()["job"]
    jobs.wait(job["job"], WAIT_S)
    done = ask("GET", first.headers["location"]).json()
    wanted = {"campaign": "nylon", "with": ["drag", "wind"], "results": ["result-0001.json"]}
    assert (done["state"], done["result"], done["share"]) == ("done", wanted, 1.0)
    again = ask("GET", f"{NYLON}/{question}?with=drag&with=wind")
    assert (again.status_code, again.json()) == (200, wanted)
    assert ask("GET", f"{NYLON}/{question}?with=wind").status_code == 202


def test_an_answer_holds_until_a_shot_is_fired_or_analysed_again(
    ask: Any, jobs: Jobs, store: Store, measure: Shoot
) -> None:
    def results() -> list[str]:
        first = ask("GET", f"{NYLON}/ranking")
        assert first.status_code == 202
        jobs.wait(first.json()["job"], WAIT_S)
        return list(ask("GET", f"{NYLON}/ranking").json()["results"])

    shot = measure()
    assert results() == ["result-0001.json"]
    analyse(store, shot)
    assert results() == ["result-0002.json"]
    measure()
    assert results() == ["result-0002.json", "result-0001.json"]


def test_an_effect_that_is_not_there_is_answered_with_those_that_are(
    ask: Any, measure: Shoot
) -> None:
    measure()
    answers = [
        ask("GET", f"{NYLON}/ranking?with=phlogiston"),
        ask("POST", f"{NYLON}/fits", json={"name": "base", "with": ["phlogiston"]}),
    ]
    for answer in answers:
        problem = answer.json()
        assert (answer.status_code, problem["code"]) == (404, "not-found")
        assert problem["value"] == "'phlogiston'"
        assert all(effect.name in problem["todo"] for effect in CATALOGUE)


@pytest.mark.parametrize(
    "query", ["with=drag&with=drag", "with=Not%20a%20name", "without=drag", "with=" + "a" * 65]
)
def test_effects_that_cannot_be_meant_are_refused(ask: Any, measure: Shoot, query: str) -> None:
    measure()
    answer = ask("GET", f"{NYLON}/ranking?{query}")
    assert (answer.status_code, answer.json()["code"]) == (422, "invalid-request")


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("GET", "agreement"),
        ("GET", "structure"),
        ("GET", "ranking"),
        ("GET", "fits"),
        ("GET", "fits/base"),
        ("POST", "explain"),
        ("POST", "reanalyse"),
    ],
)
def test_a_campaign_that_is_not_there_starts_no_job(
    ask: Any, jobs: Jobs, method: str, path: str
) -> None:
    answer = ask(method, f"{NYLON}/{path}")
    assert (answer.status_code, answer.json()["code"]) == (404, "not-found")
    assert jobs.jobs() == []


def test_a_campaign_without_a_measured_shot_starts_no_job(
    ask: Any, jobs: Jobs, shoot: Shoot
) -> None:
    shoot("nylon")
    answer = ask("POST", f"{NYLON}/explain")
    assert answer.status_code == 404
    assert "no shot of this campaign has been measured" in answer.json()["detail"]
    assert jobs.jobs() == []


def test_a_fit_is_saved_under_its_name_and_never_replaced(
    ask: Any, jobs: Jobs, measure: Shoot
) -> None:
    measure()
    for version, effects in ((1, []), (2, ["drag"])):
        order = {"name": "base", "with": effects}
        accepted = ask("POST", f"{NYLON}/fits", json=order)
        assert accepted.status_code == 202
        job = jobs.wait(accepted.json()["job"], WAIT_S)
        assert job.state == "done", job
        shown = ask("GET", f"{NYLON}/fits/base").json()
        assert (shown["name"], shown["version"], shown["fit"]["with"]) == ("base", version, effects)
    assert ask("GET", f"{NYLON}/fits/base?version=1").json()["fit"]["with"] == []
    fits = [{"name": "base", "version": 1}, {"name": "base", "version": 2}]
    assert ask("GET", f"{NYLON}/fits").json() == {"fits": fits}


@pytest.mark.parametrize(
    "order", [{}, {"name": "../up"}, {"name": "a", "with": "drag"}, {"name": "a", "effects": []}]
)
def test_an_order_that_cannot_be_is_refused_and_nothing_is_saved(
    ask: Any, jobs: Jobs, measure: Shoot, order: dict[str, Any]
) -> None:
    measure()
    assert ask("POST", f"{NYLON}/fits", json=order).status_code == 422
    assert jobs.jobs() == []


def test_a_job_that_fails_says_why_and_the_next_request_starts_another(
    ask: Any, jobs: Jobs, measure: Shoot
) -> None:
    measure("broken")
    first = ask("POST", "/api/v1/campaigns/broken/explain").json()["job"]
    jobs.wait(first, WAIT_S)
    shown = ask("GET", f"/api/v1/jobs/{first}").json()
    assert (shown["state"], shown["failure_code"]) == ("failed", "analysis-input")
    assert shown["failure"] == "result-0001.json: holds no poses; analyse it again"
    assert ask("POST", "/api/v1/campaigns/broken/explain").json()["job"] != first


def test_two_who_ask_the_same_get_one_job_and_deleting_it_kills_it(
    ask: Any, jobs: Jobs, measure: Shoot
) -> None:
    measure()
    one, two = (ask("POST", f"{NYLON}/explain") for _ in range(2))
    assert one.headers["location"] == two.headers["location"]
    deleted = ask("DELETE", one.headers["location"])
    assert (deleted.status_code, deleted.json()["state"]) == (200, "cancelled")
    assert [job.state for job in jobs.jobs()] == ["cancelled"]


def test_a_law_is_asked_for_beside_effects_and_within_the_rigs_limits(
    ask: Any, jobs: Jobs, measure: Shoot
) -> None:
    measure()
    first = ask("POST", f"{NYLON}/propose", json={"with": ["drag"]})
    assert (first.status_code, first.json()["kind"]) == (202, "propose")
    jobs.wait(first.json()["job"], WAIT_S)
    asked = ask("GET", first.headers["location"]).json()["result"]
    assert asked["with"] == ["drag"]
    assert [low < high for low, high in asked["limits"]] == [True, True]
    refused = ask("POST", f"{NYLON}/propose", json={"with": ["phlogiston"]})
    assert (refused.status_code, refused.json()["code"]) == (404, "not-found")


FORM = {
    "slot": "e",
    "arguments": ["speed_n"],
    "symbols": ["v_n"],
    "columns": ["x - x0"],
    "constants": [5.0],
    "reach": [2.0],
    "campaign": "nylon",
    "shots": "1-3,5",
}


def test_an_order_takes_all_that_a_form_states() -> None:
    assert tuple(StatedForm.model_fields) == Statement.__slots__


def test_one_form_is_asked_to_be_confirmed_as_a_proposal_states_it(
    ask: Any, jobs: Jobs, measure: Shoot
) -> None:
    measure()
    first = ask("POST", f"{NYLON}/propose", json={"confirm": FORM})
    assert first.status_code == 202
    jobs.wait(first.json()["job"], WAIT_S)
    asked = ask("GET", first.headers["location"]).json()["result"]["confirm"]
    assert {key: asked[key] for key in FORM} == FORM


def test_what_campaigns_share_is_asked_with_the_shots_of_each(
    ask: Any, jobs: Jobs, measure: Shoot
) -> None:
    measure()
    measure("glass")
    first = ask("POST", f"{NYLON}/propose", json={"together": ["glass"]})
    assert first.status_code == 202
    jobs.wait(first.json()["job"], WAIT_S)
    [other] = ask("GET", first.headers["location"]).json()["result"]["together"]
    assert (other["campaign"], len(other["files"])) == ("glass", 1)
    missing = ask("POST", f"{NYLON}/propose", json={"together": ["steel"]})
    assert (missing.status_code, missing.json()["code"]) == (404, "not-found")


@pytest.mark.parametrize(
    "order",
    [
        {"together": ["glass"], "confirm": FORM},
        {"together": ["glass", "glass"]},
        {"together": ["nylon"]},
        {"confirm": {**FORM, "slot": "phlogiston"}},
        {"confirm": {**FORM, "shots": "all"}},
        {"confirm": {**FORM, "code": "import os"}},
        {"confirm": "laws/mine.py"},
    ],
)
def test_orders_of_laws_that_cannot_be_meant_are_refused(
    ask: Any, measure: Shoot, order: dict[str, Any]
) -> None:
    measure()
    measure("glass")
    assert ask("POST", f"{NYLON}/propose", json=order).status_code == 422
