from __future__ import annotations

import tomllib
from typing import Any

import pytest

from rigctl.config import default_path
from rigctl.errors import (
    DeviceSilentError,
    InterlockError,
    RecordingNotConfirmedError,
    RefusedError,
    SettingsError,
    StoreError,
)
from rigctl.rig.states import RigState

SETTINGS = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 41.0, "offset_mm": 6.0}
ARM = "/api/v1/rig/arm"


def test_the_rig_shows_state_interlocks_and_that_it_is_simulated(ask: Any) -> None:
    rig = ask("GET", "/api/v1/rig").json()
    assert (rig["state"], rig["simulated"]) == ("idle", True)
    (pressure,) = rig["interlocks"]
    assert pressure["name"] == "pressure"
    assert pressure["age_s"] == 1.0
    assert pressure["unit"] == "kPa"


def test_arming_hands_the_settings_to_the_rig_and_gives_its_token(ask: Any, rig: Any) -> None:
    answer = ask("POST", ARM, json=SETTINGS)
    assert answer.status_code == 200
    assert answer.json()["arm_token"] == "token-1"
    assert answer.json()["expires_at"] == "2026-01-31T12:00:00Z"
    ((settings, _),) = rig.armed
    assert settings.model_dump(exclude_none=True) == SETTINGS | {"delay_us": 0.0}


STRICT = [
    ("offset_mm", b"false"),
    ("offset_mm", b'"3"'),
    ("offset_mm", b"null"),
    ("offset_mm", b"NaN"),
    ("offset_mm", b"Infinity"),
    ("offset_mm", b"-1e999"),
    ("offset_mm", b"[6]"),
    ("pressure_a_kpa", b"true"),
    ("pressure_b_kpa", b"-1"),
    ("delay_us", b'"0"'),
    ("ofset_mm", b"6"),
]


@pytest.mark.parametrize(("field", "value"), STRICT)
def test_what_is_not_a_number_within_bounds_is_refused_by_name(
    ask: Any, rig: Any, field: str, value: bytes
) -> None:
    fields = {name: str(number).encode() for name, number in SETTINGS.items()}
    fields[field] = value
    body = b"{" + b", ".join(b'"%s": %s' % (n.encode(), v) for n, v in fields.items()) + b"}"
    answer = ask("POST", ARM, content=body, headers={"Content-Type": "application/json"})
    problem = answer.json()
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"
    assert problem["field"] == field
    assert field in problem["detail"]
    assert problem["code"] == "invalid-request"
    assert not rig.armed


def test_every_faulty_field_is_named_at_once(ask: Any) -> None:
    problem = ask("POST", ARM, json={"pressure_a_kpa": -1, "extra": 1}).json()
    assert {error["field"] for error in problem["errors"]} == {
        "pressure_a_kpa",
        "pressure_b_kpa",
        "offset_mm",
        "extra",
    }
    first = next(e for e in problem["errors"] if e["field"] == "pressure_a_kpa")
    low, high = tomllib.loads(default_path().read_text())["limits"]["pressure_kpa"]
    assert (first["value"], first["limit"]) == ("-1", f"{low:g} to {high:g} kPa")
    assert first["detail"] == "lies outside the rig's limits"


@pytest.mark.parametrize("body", [b"", b"{", b"[]", b"7", b'"x"', b"\xff\xfe"])
def test_a_body_that_is_no_object_is_a_problem_document(ask: Any, body: bytes) -> None:
    answer = ask("POST", ARM, content=body, headers={"Content-Type": "application/json"})
    assert (answer.status_code, answer.json()["code"]) == (422, "invalid-request")
    assert answer.headers["content-type"] == "application/problem+json"


JSON = {"Content-Type": "application/json"}
TWICE = b'{"pressure_a_kpa": 40, "pressure_b_kpa": 41, "offset_mm": 6, "pressure_a_kpa": 90}'


def test_a_key_that_stands_twice_is_refused_by_name_and_arms_nothing(ask: Any, rig: Any) -> None:
    answer = ask("POST", ARM, content=TWICE, headers=JSON)
    problem = answer.json()
    assert (answer.status_code, problem["code"]) == (422, "invalid-request")
    assert (problem["field"], problem["value"]) == ("pressure_a_kpa", "[40, 90]")
    assert problem["detail"] == "pressure_a_kpa: stands 2 times"
    assert not rig.armed


def test_every_key_that_stands_twice_is_named_even_with_one_value(ask: Any, rig: Any) -> None:
    body = b'{"offset_mm": 6, "delay_us": 0, "offset_mm": 6, "delay_us": 0, "delay_us": 0}'
    problem = ask("POST", ARM, content=body, headers=JSON).json()
    assert [each["field"] for each in problem["errors"]] == ["offset_mm", "delay_us"]
    assert problem["errors"][1]["detail"] == "stands 3 times"
    assert not rig.armed


@pytest.mark.parametrize(
    ("path", "body"),
    [
        ("/api/v1/shots", b'{"arm_token": "t", "arm_token": "u"}'),
        ("/api/v1/rig/release", b'{"reason": "looked", "reason": "not"}'),
        (ARM, b'{"offset_mm": {"a": 1, "a": 2}}'),
    ],
)
def test_no_route_takes_one_of_two_values(ask: Any, rig: Any, path: str, body: bytes) -> None:
    answer = ask("POST", path, content=body, headers={**JSON, "Idempotency-Key": "k"})
    assert answer.status_code == 422
    assert "stands 2 times" in answer.json()["detail"]
    assert (rig.armed, rig.fires, rig.releases) == ([], [], [])


def test_a_stop_whose_reason_stands_twice_stops_without_one(ask: Any, rig: Any) -> None:
    answer = ask("POST", "/api/v1/rig/estop", content=b'{"reason": "a", "reason": "b"}')
    assert answer.status_code == 200
    assert [reason for _, reason in rig.stops] == ["emergency stop by REST"]


def test_a_body_that_is_no_json_says_where_it_ends_to_be(ask: Any) -> None:
    problem = ask("POST", ARM, content=b'{"offset_mm": 6,, }', headers=JSON).json()
    assert problem["field"] == "body"
    assert problem["detail"].startswith("body: is not JSON: ")
    assert problem["detail"].endswith(" at character 17")
    assert "value" not in problem


@pytest.mark.parametrize("body", [b'{"\\ud800": 1}', b'{"\\ud800": 1, "\\ud800": 1}', b"[" * 9000])
def test_a_body_that_no_text_can_repeat_is_refused_all_the_same(ask: Any, body: bytes) -> None:
    answer = ask("POST", ARM, content=body, headers=JSON)
    assert (answer.status_code, answer.json()["code"]) == (422, "invalid-request")


REFUSALS = [
    (SettingsError("too high", part="pressure_a_kpa"), 422, "settings-out-of-range"),
    (RefusedError("the rig is firing"), 409, "refused"),
    (InterlockError("a; b", tripped=("a", "b")), 409, "interlock"),
    (DeviceSilentError("no answer", part="regulator"), 503, "device-silent"),
    (RecordingNotConfirmedError("no frames"), 503, "recording-not-confirmed"),
    (StoreError("disk full"), 503, "store"),
]


@pytest.mark.parametrize(("error", "status", "code"), REFUSALS)
def test_each_refusal_has_its_status_and_stable_code(
    ask: Any, rig: Any, error: Exception, status: int, code: str
) -> None:
    rig.refusal = error
    answer = ask("POST", ARM, json=SETTINGS)
    problem = answer.json()
    assert (answer.status_code, problem["status"], problem["code"]) == (status, status, code)
    assert problem["type"] == f"urn:rigctl:{code}"
    assert problem["detail"] == str(error)


def test_a_refused_arming_names_every_interlock(ask: Any, rig: Any) -> None:
    rig.refusal = InterlockError("pressure: 3 kPa; slide: moving", tripped=("pressure", "slide"))
    assert ask("POST", ARM, json=SETTINGS).json()["interlocks"] == ["pressure", "slide"]


def test_an_error_nobody_foresaw_says_so_without_its_inside(ask: Any, rig: Any) -> None:
    rig.refusal = ZeroDivisionError("secret detail")
    answer = ask("POST", ARM, json=SETTINGS)
    assert (answer.status_code, answer.json()["code"]) == (500, "internal")
    assert "secret detail" not in answer.text


BODIES = [b"", b"{", b"[]", b'{"reason": 3}', b'{"reason": "x", "more": 1}', b"\xff" * 40_000]


@pytest.mark.parametrize("body", BODIES)
def test_a_stop_is_never_refused_for_its_body(ask: Any, rig: Any, body: bytes) -> None:
    answer = ask("POST", "/api/v1/rig/estop", content=body)
    assert answer.status_code == 200
    assert answer.json()["state"] == "estop"
    assert rig.stops[0][1] == "emergency stop by REST"


def test_a_stop_hands_its_reason_on(ask: Any, rig: Any) -> None:
    ask("POST", "/api/v1/rig/estop", json={"reason": "smoke"})
    assert rig.stops[0][1] == "smoke"


def test_releasing_needs_a_reason(ask: Any, rig: Any) -> None:
    rig.state = RigState.ESTOP
    for body in ({}, {"reason": ""}, {"reason": 1}, {"reason": "two\nlines"}):
        answer = ask("POST", "/api/v1/rig/release", json=body)
        assert (answer.status_code, answer.json()["field"]) == (422, "reason")
    assert not rig.releases
    answer = ask("POST", "/api/v1/rig/release", json={"reason": "looked, all clear"})
    assert answer.json()["state"] == "idle"
    assert rig.releases[0][1] == "looked, all clear"


def test_a_latched_rig_lives_but_is_not_ready(ask: Any, rig: Any) -> None:
    assert ask("GET", "/health/ready").json() == {
        "status": "ready",
        "simulated": True,
        "interrupted": 1,
        "unknown_outcome": 0,
        "completed": 2,
        "wrong_keys": 0,
    }
    rig.state = RigState.ESTOP
    answer = ask("GET", "/health/ready")
    assert (answer.status_code, answer.json()["code"]) == (503, "not-ready")
    assert ask("GET", "/health/live").json() == {"status": "live"}
