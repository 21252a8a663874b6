"""The plotting library that browsers get is the published one, as a module, packed where asked."""

from __future__ import annotations

import asyncio
import hashlib

import pytest
from fastapi import FastAPI
from httpx import ASGITransport, AsyncClient

from rigctl.page.parts.plotting import ADDRESS, LIBRARY, VERSION, plotting_route


def test_the_library_is_the_published_one_that_its_folder_names() -> None:
    content = LIBRARY.read_bytes()
    named = LIBRARY.with_name("README.md").read_text()
    assert hashlib.sha256(content).hexdigest() in named
    assert f"plotly.js {VERSION}" in named
    assert f"(cartesian - minified) v{VERSION}".encode() in content[:200]


@pytest.mark.parametrize("taken", ["gzip, br", "identity"])
def test_it_is_a_module_for_those_who_unpack_and_those_who_do_not(taken: str) -> None:
    packed, module = asyncio.run(asked_for(taken))
    assert packed == ("gzip" in taken)
    assert module.startswith(LIBRARY.read_bytes())
    assert module.removeprefix(LIBRARY.read_bytes()).count(b"export const Plotly =") == 1


async def asked_for(taken: str) -> tuple[bool, bytes]:
    """Return whether the module came packed, and the module."""
    app = FastAPI()
    plotting_route(app)
    async with AsyncClient(transport=ASGITransport(app), base_url="http://page") as client:
        answer = await client.get(ADDRESS, headers={"Accept-Encoding": taken})
    return answer.headers.get("content-encoding") == "gzip", answer.content
