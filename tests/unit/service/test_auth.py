from __future__ import annotations

from typing import Any

import pytest

LOCKED = [
    ("GET", "/api/v1/rig"),
    ("POST", "/api/v1/rig/arm"),
    ("POST", "/api/v1/rig/release"),
    ("POST", "/api/v1/shots"),
    ("GET", "/api/v1/shots"),
    ("GET", "/api/v1/shots/20260131-000001"),
    ("GET", "/api/v1/shots/20260131-000001/result"),
    ("GET", "/api/v1/shots/20260131-000001/frames/0.png"),
    ("GET", "/api/v1/events"),
    ("GET", "/api/v1/nothing-there"),
]


@pytest.mark.parametrize(("method", "path"), LOCKED)
def test_without_a_key_nothing_under_the_api_answers(ask: Any, method: str, path: str) -> None:
    answer = ask(method, path, key=None, content=b"not even read")
    assert answer.status_code == 401
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.headers["www-authenticate"].startswith("Bearer")
    assert answer.json()["code"] == "unauthorized"


def test_no_route_of_the_document_but_the_stop_answers_without_a_key(app: Any, ask: Any) -> None:
    for path, operations in app.openapi()["paths"].items():
        if path.startswith("/api/v1/") and path != "/api/v1/rig/estop":
            for method in operations:
                assert ask(method.upper(), path, key=None).status_code == 401, (method, path)


@pytest.mark.parametrize(
    "header",
    ["", "Bearer", "Bearer ", "Bearer wrong", "Basic a-key-for-tests", "a-key-for-tests"],
)
def test_a_wrong_key_or_scheme_is_refused(ask: Any, header: str) -> None:
    answer = ask("GET", "/api/v1/rig", key=None, headers={"Authorization": header})
    assert answer.status_code == 401


def test_a_key_of_foreign_letters_is_refused_and_breaks_nothing(ask: Any) -> None:
    answer = ask("GET", "/api/v1/rig", key=None, headers={"Authorization": "Bearer é".encode()})
    assert answer.status_code == 401


def test_the_scheme_may_be_written_in_small_letters(ask: Any) -> None:
    header = {"Authorization": "bearer a-key-for-tests"}
    assert ask("GET", "/api/v1/rig", key=None, headers=header).status_code == 200


def test_health_and_the_api_document_need_no_key(ask: Any) -> None:
    for path in ("/health/live", "/health/ready", "/openapi.json"):
        assert ask("GET", path, key=None).status_code == 200


@pytest.mark.parametrize("key", [None, "wrong", "a-key-for-tests"])
def test_the_emergency_stop_takes_any_key_and_none(ask: Any, rig: Any, key: str | None) -> None:
    assert ask("POST", "/api/v1/rig/estop", key=key).status_code == 200
    assert len(rig.stops) == 1


def test_the_journal_learns_whose_key_it_was_but_never_the_key(ask: Any, rig: Any) -> None:
    ask("POST", "/api/v1/rig/estop")
    ask("POST", "/api/v1/rig/estop", key="wrong")
    (right, _), (wrong, _) = rig.stops
    assert right.startswith("key ")
    assert wrong.startswith("no key")
    assert "a-key-for-tests" not in right
