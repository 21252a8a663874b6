"""Who gets through the door to the page, and who to REST."""

from __future__ import annotations

import asyncio
from pathlib import Path

import httpx
import pytest
from starlette.responses import PlainTextResponse

from rigctl.access.keyring import Keyring
from rigctl.access.wrong_keys import WrongKeys
from rigctl.page.session_auth import SessionAuth

KEY = "a-key-for-tests"
DOOR = SessionAuth(
    PlainTextResponse("rest"),
    PlainTextResponse("page"),
    Keyring(KEY, lambda: Path("nowhere")),
    WrongKeys(lambda address: None),
)


def asked(
    path: str,
    *,
    method: str = "GET",
    cookies: dict[str, str] | None = None,
    headers: dict[str, str] | None = None,
) -> httpx.Response:
    async def ask() -> httpx.Response:
        transport = httpx.ASGITransport(DOOR)
        async with httpx.AsyncClient(
            transport=transport, base_url="http://rig", cookies=cookies
        ) as client:
            return await client.request(method, path, headers=headers)

    return asyncio.run(ask())


def session() -> dict[str, str]:
    name, _, value = asked(f"/?key={KEY}").headers["set-cookie"].partition(";")[0].partition("=")
    return {name: value}


def test_the_key_is_taken_out_of_the_address_and_becomes_a_session() -> None:
    answer = asked(f"/?key={KEY}")
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert KEY not in cookie
    assert asked("/shots", cookies=session()).text == "page"


def test_a_wrong_key_opens_nothing() -> None:
    answer = asked("/?key=another")
    assert answer.status_code == 401
    assert "set-cookie" not in answer.headers


def test_without_a_session_only_the_front_is_answered() -> None:
    assert asked("/").text == "rest"
    assert asked("/model").headers["location"] == "/"


@pytest.mark.parametrize("path", ["/api/v1/rig", "/health/live", "/metrics", "/openapi.json"])
def test_rest_is_asked_with_or_without_a_session(path: str) -> None:
    assert asked(path).text == "rest"
    assert asked(path, cookies=session()).text == "rest"


def test_a_socket_without_a_session_is_closed() -> None:
    sent: list[dict[str, object]] = []

    async def send(message: dict[str, object]) -> None:
        sent.append(message)

    async def receive() -> dict[str, object]:
        return {"type": "websocket.connect"}

    scope = {"type": "websocket", "path": "/socket", "headers": [], "query_string": b""}
    asyncio.run(DOOR(scope, receive, send))
    assert [message["type"] for message in sent] == ["websocket.close"]


def test_a_damaged_cookie_is_no_session() -> None:
    assert asked("/shots", headers={"cookie": 'rigctl-\x7f="'}).status_code == 303
