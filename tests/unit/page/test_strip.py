"""The strip below a film: which frames it shows, and their one picture."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import cv2
import httpx
import numpy as np
import pytest
from fastapi import FastAPI

from rigctl.page.shots.film import film_route, strip_address
from rigctl.page.shots.player import frames_about

FRAMES = np.random.default_rng(4).integers(0, 256, (12, 6, 8), np.uint8)


@pytest.fixture(scope="module")
def page() -> FastAPI:
    store = SimpleNamespace(frames=lambda _: SimpleNamespace(pixels=FRAMES))
    app = FastAPI()
    desk: Any = SimpleNamespace(daemon=SimpleNamespace(store=store))
    film_route(app, desk)
    return app


def got(app: FastAPI, address: str) -> httpx.Response:
    async def ask() -> httpx.Response:
        way = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=way, base_url="http://page") as client:
            return await client.get(address)

    return asyncio.run(ask())


@pytest.mark.parametrize(
    ("contact", "count", "shown"),
    [
        (20, 40, [4, 10, 14, 18, 20, 22, 26, 30, 36]),
        (0, 40, [0, 2, 6, 10, 16]),
        (1, 3, [1]),
        (0, 1, [0]),
    ],
)
def test_the_strip_shows_frames_about_the_contact(
    contact: int, count: int, shown: list[int]
) -> None:
    found = frames_about(contact, count)
    assert found == shown


def test_frames_stand_beside_one_another_in_one_picture(page: FastAPI) -> None:
    drawn = got(page, strip_address("shot-1", [3, 0, 11]))
    assert "immutable" in drawn.headers["cache-control"]
    picture = cv2.imdecode(np.frombuffer(drawn.content, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    for place, frame in enumerate((3, 0, 11)):
        assert np.array_equal(picture[:, 8 * place : 8 * (place + 1)], FRAMES[frame])


@pytest.mark.parametrize(
    ("frames", "status"), [("3-12", 404), ("3-x", 422), ("-".join("12345678901"), 422), ("", 404)]
)
def test_a_strip_that_cannot_be_is_refused(page: FastAPI, frames: str, status: int) -> None:
    assert got(page, f"/film/shot-1/strip/{frames}.png").status_code == status
