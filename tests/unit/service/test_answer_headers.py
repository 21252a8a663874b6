"""What every answer tells a browser: load nothing from elsewhere, be framed by nobody."""

from __future__ import annotations

import asyncio

import httpx
import pytest
from starlette.responses import PlainTextResponse

from rigctl.service.guards.origins import HEADERS, AnswerHeaders, OriginGuard, OwnOrigins

APP = AnswerHeaders(OriginGuard(PlainTextResponse("page"), OwnOrigins()))


@pytest.mark.parametrize("host", ["127.0.0.1", "evil.example"])
def test_every_answer_carries_the_headers_a_refusal_too(host: str) -> None:
    async def ask() -> httpx.Response:
        transport = httpx.ASGITransport(APP)
        async with httpx.AsyncClient(transport=transport, base_url=f"http://{host}") as client:
            return await client.get("/")

    answer = asyncio.run(ask())
    assert {name: answer.headers[name] for name in HEADERS} == HEADERS


def test_the_policy_names_no_other_site_and_lets_nobody_frame_the_page() -> None:
    policy = HEADERS["Content-Security-Policy"]
    assert "http" not in policy
    assert "*" not in policy
    assert "frame-ancestors 'none'" in policy
