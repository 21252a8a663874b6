from __future__ import annotations

from typing import Any

import pytest

PATHS = [
    ("/api/v1/rig", "GET"),
    ("/api/v1/rig/arm", "POST"),
    ("/api/v1/rig/estop", "POST"),
    ("/api/v1/rig/release", "POST"),
    ("/api/v1/shots", "GET, POST"),
    ("/api/v1/shots/20260131-000001", "GET"),
    ("/api/v1/shots/20260131-000001/result", "GET"),
    ("/api/v1/shots/20260131-000001/frames/3.png", "GET"),
    ("/api/v1/events", "GET"),
    ("/health/live", "GET"),
    ("/health/ready", "GET"),
    ("/metrics", "GET"),
    ("/openapi.json", "GET"),
]


@pytest.mark.parametrize(("path", "allowed"), PATHS)
def test_a_method_that_a_path_does_not_know_is_answered_with_those_it_knows(
    ask: Any, path: str, allowed: str
) -> None:
    for method in ("PUT", "DELETE", "PATCH"):
        answer = ask(method, path)
        assert answer.status_code == 405
        assert answer.headers["allow"] == allowed
        assert answer.json()["code"] == "method-not-allowed"


@pytest.mark.parametrize("path", ["/api/v1/", "/api/v1/sweep", "/api/v1/shots/", "/docs"])
def test_a_path_that_is_not_there_is_a_problem_document(ask: Any, path: str) -> None:
    answer = ask("GET", path)
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["code"] == "no-such-route"


def test_too_long_a_body_is_refused_unread(ask: Any, rig: Any) -> None:
    answer = ask("POST", "/api/v1/rig/arm", content=b" " * 20_000)
    assert (answer.status_code, answer.json()["code"]) == (413, "body-too-large")
    assert not rig.armed


def test_a_body_that_does_not_say_how_long_it_is_is_refused_unread(ask: Any) -> None:
    headers = {"Transfer-Encoding": "chunked"}
    answer = ask("POST", "/api/v1/rig/arm", content=b"{}", headers=headers)
    assert (answer.status_code, answer.json()["code"]) == (411, "length-required")


def test_every_route_documents_its_refusals_as_problem_documents(app: Any) -> None:
    document = app.openapi()
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            answers = operation["responses"]
            assert "405" in answers, (method, path)
            locked = path.startswith("/api/v1/") and path != "/api/v1/rig/estop"
            assert ("401" in answers) == locked, (method, path)
            scope = operation.get("x-scope")
            assert operation["security"] == ([{"key": [scope]}] if locked else [])
            assert "403" in answers, (method, path)
            for status, answer in answers.items():
                if int(status) >= 400:
                    assert list(answer["content"]) == ["application/problem+json"]
    assert "HTTPValidationError" not in document["components"]["schemas"]


def test_the_document_asks_for_settings_within_the_limits_of_this_rig(app: Any) -> None:
    document = app.openapi()
    body = document["paths"]["/api/v1/rig/arm"]["post"]["requestBody"]["content"]
    name = body["application/json"]["schema"]["$ref"].rpartition("/")[2]
    order = document["components"]["schemas"][name]
    assert order["additionalProperties"] is False
    pressure = order["properties"]["pressure_a_kpa"]
    assert (pressure["minimum"], pressure["maximum"]) == (5.0, 120.0)
    assert "angle_a_deg" not in order["properties"]


def test_the_document_lets_stored_shots_have_been_fired_under_other_limits(app: Any) -> None:
    settings = app.openapi()["components"]["schemas"]["ShotSettings"]["properties"]
    assert settings["pressure_a_kpa"]["maximum"] == 1000
    assert "angle_a_deg" in settings


def test_the_routes_are_those_of_the_contract(app: Any) -> None:
    assert set(app.openapi()["paths"]) == {
        "/api/v1/rig",
        "/api/v1/rig/arm",
        "/api/v1/rig/estop",
        "/api/v1/rig/release",
        "/api/v1/rig/commissioning",
        "/api/v1/rig/commissioning/record",
        "/api/v1/rig/commissioning/rewired",
        "/api/v1/rig/commissioning/{step}/act",
        "/api/v1/rig/commissioning/{step}/answer",
        "/api/v1/rig/film",
        "/api/v1/rig/film/{name}",
        "/api/v1/rig/recorder",
        "/api/v1/rig/recorder/picture.png",
        "/api/v1/shots",
        "/api/v1/shots/{shot}",
        "/api/v1/shots/{shot}/exclude",
        "/api/v1/shots/{shot}/include",
        "/api/v1/shots/{shot}/note",
        "/api/v1/shots/{shot}/tags",
        "/api/v1/shots/{shot}/frames/{number}.png",
        "/api/v1/shots/{shot}/result",
        "/api/v1/sweeps",
        "/api/v1/sweeps/{sweep}",
        "/api/v1/sweeps/{sweep}/steps",
        "/api/v1/sweeps/{sweep}/pause",
        "/api/v1/sweeps/{sweep}/resume",
        "/api/v1/sweeps/{sweep}/abort",
        "/api/v1/campaigns",
        "/api/v1/campaigns/{campaign}",
        "/api/v1/campaigns/{campaign}/note",
        "/api/v1/campaigns/{campaign}/tags",
        "/api/v1/campaigns/{campaign}/reanalyse",
        "/api/v1/campaigns/{campaign}/report",
        "/api/v1/campaigns/{campaign}/agreement",
        "/api/v1/campaigns/{campaign}/structure",
        "/api/v1/campaigns/{campaign}/ranking",
        "/api/v1/campaigns/{campaign}/explain",
        "/api/v1/campaigns/{campaign}/propose",
        "/api/v1/campaigns/{campaign}/next",
        "/api/v1/campaigns/{campaign}/fits",
        "/api/v1/campaigns/{campaign}/fits/{fit}",
        "/api/v1/effects",
        "/api/v1/effects/own",
        "/api/v1/effects/{effect}",
        "/api/v1/jobs",
        "/api/v1/jobs/{job}",
        "/api/v1/events",
        "/health/live",
        "/health/ready",
    }


def test_the_printed_address_says_which_rig_answers_and_how_to_speak_to_it(ask: Any) -> None:
    answer = ask("GET", "/?key=whatever")
    assert answer.status_code == 200
    assert "simulated" in answer.text
    assert "Authorization: Bearer" in answer.text
