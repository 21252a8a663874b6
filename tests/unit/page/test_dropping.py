"""What is cancelled while the daemon takes it in is not kept, nor read for a shot."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from fastapi import FastAPI

from rigctl.page.own import dropping
from rigctl.page.own.brought import brought_before
from rigctl.page.rig import film

BOUNDARY = "parted"
WAIT_S = 30.0


class Browser:
    """Sends one file; leaves when it is told to, or waits for the answer."""

    def __init__(self, app: FastAPI) -> None:
        self._app = app
        self._told, self._left = asyncio.Event(), threading.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._sent: list[dict[str, Any]] = []

    def leave(self) -> None:
        """Leave, called by a thread; return when the daemon has been told."""
        assert self._loop is not None
        self._loop.call_soon_threadsafe(self._told.set)
        assert self._left.wait(WAIT_S)

    def send(self, address: str) -> int:
        """Send a film as the page does; return the status of the answer."""
        body = (
            f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="files"; filename="a.mp4"\r\n'
            f"Content-Type: video/mp4\r\n\r\nframes\r\n--{BOUNDARY}--\r\n"
        ).encode()
        asyncio.run(self._send(address, body))
        return int(self._sent[0]["status"])

    async def _send(self, address: str, body: bytes) -> None:
        self._loop = asyncio.get_running_loop()
        headers = [
            (b"content-type", f"multipart/form-data; boundary={BOUNDARY}".encode()),
            (b"content-length", str(len(body)).encode()),
        ]
        request = {"type": "http.request", "body": body, "more_body": False}
        parts = [request]

        async def receive() -> Any:
            if parts:
                return parts.pop()
            await self._told.wait()
            self._left.set()
            return {"type": "http.disconnect"}

        async def send(message: Any) -> None:
            self._sent.append(message)

        scope = {
            "type": "http", "method": "POST", "path": address, "raw_path": address.encode(),
            "query_string": b"", "headers": headers, "http_version": "1.1", "scheme": "http",
            "root_path": "", "client": ("127.0.0.1", 1), "server": ("127.0.0.1", 2),
        }  # fmt: skip
        await self._app(scope, receive, send)


@pytest.fixture
def app() -> FastAPI:
    return FastAPI(openapi_url=None)


def after(leave: Callable[[], None], go: Callable[..., Any]) -> Callable[..., Any]:
    def left(*given: Any) -> Any:
        leave()
        return go(*given)

    return left


def test_what_is_cancelled_while_it_is_looked_at_is_not_kept(
    app: FastAPI, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk: Any = SimpleNamespace(daemon=SimpleNamespace(store=SimpleNamespace(path=tmp_path)))
    dropping.dropping_route(app, desk)
    assert Browser(app).send(dropping.ADDRESS) == 200
    assert [one.name for one in brought_before(tmp_path)] == ["a.mp4"]
    browser = Browser(app)
    looks = after(browser.leave, dropping.what_is_in)
    monkeypatch.setattr(dropping, "what_is_in", looks)
    assert browser.send(dropping.ADDRESS) == 400
    assert len(list((tmp_path / "own").iterdir())) == 1


def test_a_film_that_is_cancelled_while_it_is_copied_is_not_read_for_its_shot(
    app: FastAPI, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[Path] = []

    def bring(_jobs: object, _film: object, path: Path) -> Any:
        read.append(path)
        return SimpleNamespace(id="1")

    store, camera = SimpleNamespace(path=tmp_path), SimpleNamespace(require=lambda wish: None)
    desk: Any = SimpleNamespace(daemon=SimpleNamespace(store=store, film=camera, jobs=None))
    monkeypatch.setattr(film, "bring_film", bring)
    film.shot_film_route(app, desk)
    assert Browser(app).send(film.ADDRESS) == 200
    assert [path.read_bytes() for path in read] == [b"frames"]
    browser, copies = Browser(app), film.keep

    async def keep(*given: Any) -> None:
        await asyncio.to_thread(browser.leave)
        await copies(*given)

    monkeypatch.setattr(film, "keep", keep)
    assert browser.send(film.ADDRESS) == 400
    assert len(read) == 1
