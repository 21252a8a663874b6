"""What a request says twice, in another coding, or with hidden characters, is refused."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from typing import Any

import httpx
import pytest

from tests.unit.service.conftest import KEY

SHOTS = "/api/v1/shots"
SETTINGS = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": 6.0}


@pytest.mark.parametrize(
    ("path", "field", "words"),
    [
        (f"{SHOTS}?tag=wet&tag=cold", "tag", "stands 2 times"),
        (f"{SHOTS}?limit=1&limit=2&limit=3", "limit", "stands 3 times"),
        (f"{SHOTS}?colour=red", "colour", "is no parameter of this path"),
        ("/api/v1/rig?x=1", "x", "is no parameter of this path"),
        ("/api/v1/effects?x=", "x", "is no parameter of this path"),
        ("/api/v1/jobs?limit=1", "limit", "is no parameter of this path"),
        ("/api/v1/campaigns?tag=wet&tag=wet", "tag", "stands 2 times"),
    ],
)
def test_a_parameter_that_stands_twice_or_is_not_known_is_refused(
    ask: Any, path: str, field: str, words: str
) -> None:
    answer = ask("GET", path)
    assert (answer.status_code, answer.json()["field"]) == (422, field)
    assert words in answer.json()["detail"]


def test_every_locked_path_documents_that_refusal(app: Any) -> None:
    for path, operations in app.openapi()["paths"].items():
        if path.startswith("/api/v1/") and path != "/api/v1/rig/estop":
            assert all("422" in operation["responses"] for operation in operations.values())


def test_the_emergency_stop_and_health_are_not_refused_for_their_form(ask: Any, rig: Any) -> None:
    assert ask("POST", "/api/v1/rig/estop?now=1&now=2").status_code == 200
    assert ask("GET", "/health/live?probe=7").status_code == 200


def test_two_idempotency_keys_are_refused_and_nothing_fires(ask: Any, app: Any, rig: Any) -> None:
    token = ask("POST", "/api/v1/rig/arm", json=SETTINGS).json()["arm_token"]
    headers = [
        ("Authorization", f"Bearer {KEY}"), ("Idempotency-Key", "k1"), ("Idempotency-Key", "k2"),
    ]  # fmt: skip

    async def send() -> httpx.Response:
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://rig") as client:
            return await client.post(SHOTS, json={"arm_token": token}, headers=headers)

    answer = asyncio.run(send())
    assert (answer.status_code, answer.json()["code"]) == (400, "idempotency")
    assert "stands 2 times" in answer.json()["detail"]
    assert not rig.fires


@pytest.mark.parametrize("coding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_a_body_in_another_coding_than_utf_8_is_refused(ask: Any, rig: Any, coding: str) -> None:
    answer = ask("POST", "/api/v1/rig/arm", content=json.dumps(SETTINGS).encode(coding))
    assert answer.status_code == 422
    assert "is not JSON in UTF-8" in answer.json()["detail"]
    assert not rig.armed


HARMFUL = ["a\nb", "a\x7fb", "\x9b31m", "a\u202eb", "\u2066a", "\u200fa", "a\ufeff", "a\u2028b"]


@pytest.mark.parametrize("text", HARMFUL)
def test_notes_and_reasons_with_characters_of_control_or_direction_are_refused(
    ask: Any, shoot: Callable[..., str], text: str
) -> None:
    shot = shoot("nylon")
    for method, path, body in (
        ("PUT", f"{SHOTS}/{shot}/note", {"note": text}),
        ("POST", f"{SHOTS}/{shot}/exclude", {"reason": text}),
        ("PUT", "/api/v1/campaigns/nylon/note", {"note": text}),
        ("POST", "/api/v1/rig/release", {"reason": text}),
    ):
        answer = ask(method, path, json=body)
        assert (answer.status_code, answer.json()["code"]) == (422, "invalid-request"), path


def test_words_of_any_script_are_taken(ask: Any, shoot: Callable[..., str]) -> None:
    shot = shoot()
    for text in ("naïve 23 °C", "می‌خواهم", "碰撞", "क्‍ष", "👩‍🔬 saw it"):
        answer = ask("PUT", f"{SHOTS}/{shot}/note", json={"note": text})
        assert answer.json()["note"] == text
