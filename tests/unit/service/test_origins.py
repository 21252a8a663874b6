"""Whose requests are ours: by the headers that only browsers send, and by the name in Host."""

from __future__ import annotations

import asyncio
from typing import Any

import httpx
import pytest
from starlette.responses import PlainTextResponse

from rigctl.service.guards.origins import OriginGuard, OwnOrigins

ORIGINS = OwnOrigins(("lab.example", "Rig.Example"))
GUARDED = OriginGuard(PlainTextResponse("answered"), ORIGINS)


def status(host: str = "127.0.0.1:8486", method: str = "POST", **headers: str) -> int:
    sent = {name.replace("_", "-"): value for name, value in headers.items()}

    async def ask() -> int:
        transport = httpx.ASGITransport(GUARDED)
        async with httpx.AsyncClient(transport=transport, base_url=f"http://{host}") as client:
            answer = await client.request(method, "/api/v1/rig/estop", headers=sent)
            return answer.status_code

    return asyncio.run(ask())


@pytest.mark.parametrize(
    "host",
    ["127.0.0.1:8486", "localhost:9000", "[::1]:8486", "10.0.0.7", "lab.example", "rig.example:80"],
)
def test_a_program_without_browser_headers_is_let_through_under_every_name_of_ours(
    host: str,
) -> None:
    assert status(host) == 200


@pytest.mark.parametrize("host", ["evil.example", "localhost.evil.example", "127.0.0.1.nip.io"])
def test_a_name_that_is_not_ours_is_refused_as_when_it_was_made_to_mean_our_address(
    host: str,
) -> None:
    assert status(host, "GET") == 403


@pytest.mark.parametrize("method", ["GET", "POST", "PUT", "DELETE", "OPTIONS"])
@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": "http://127.0.0.1:9999"},
        {"sec_fetch_site": "cross-site"},
        {"sec_fetch_site": "same-site"},
    ],
)
def test_what_another_page_sends_is_refused_whatever_its_method(
    method: str, headers: dict[str, str]
) -> None:
    assert status("127.0.0.1:8486", method, **headers) == 403


def test_our_own_page_and_a_typed_address_are_let_through() -> None:
    own = {"origin": "http://127.0.0.1:8486", "sec_fetch_site": "same-origin"}
    assert status(**own) == 200
    assert status(method="GET", sec_fetch_site="none") == 200


def test_the_socket_of_another_page_is_closed() -> None:
    sent: list[Any] = []

    async def send(message: Any) -> None:
        sent.append(message)

    async def receive() -> Any:
        return {"type": "websocket.connect"}

    headers = [(b"host", b"127.0.0.1:8486"), (b"origin", b"http://evil.example")]
    scope = {"type": "websocket", "path": "/socket", "headers": headers}
    asyncio.run(GUARDED(scope, receive, send))
    assert [message["type"] for message in sent] == ["websocket.close"]
