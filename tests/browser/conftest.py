"""A daemon of its own on a free port, and Chromium in front of it."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, Page, Request, expect, sync_playwright

from benchmarks.page_served import CHROMIUM, KEY, SWITCHES, started

WAIT_S = 60.0
EXPECT_MS = 60_000
"""A busy host draws slowly; what is expected sooner says so."""
expect.set_options(timeout=EXPECT_MS)
WIDE = {"width": 1280, "height": 800}
PORT = ("--port", "0")
LOOPBACK = {"127.0.0.1", None}


@dataclass
class Served:
    """A running daemon: its address, the folder that it runs in, and its process."""

    url: str
    folder: Path
    process: subprocess.Popen[str]

    @classmethod
    def start(cls, folder: Path, *options: str) -> Served:
        """Start a daemon and wait for the address that it prints."""
        process, url = started(folder, options or PORT)
        return cls(url, folder, process)

    def start_again(self) -> None:
        """Start a daemon at the same address once this one has ended."""
        self.end()
        self.process = self.start(self.folder, "--port", str(urlsplit(self.url).port)).process

    def end(self) -> None:
        """End it; a killed or halted one as well."""
        self.process.send_signal(signal.SIGCONT)
        self.process.terminate()
        self.process.communicate(timeout=WAIT_S)


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    running = Served.start(tmp_path_factory.mktemp("daemon"))
    yield running
    running.end()


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """Serve modules that mind no shots and no fits of each other: a start costs some seconds."""
    running = Served.start(tmp_path_factory.mktemp("shared"))
    yield running
    running.end()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Launch it for one module: while it is open, no other test can run an event loop."""
    if CHROMIUM is None:
        pytest.skip("no Chromium is installed")
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=SWITCHES)
        yield opened
        opened.close()


@pytest.fixture
def page(browser: Browser, served: Served) -> Iterator[Page]:
    """Open the address that the daemon prints; whatever is asked for must come from loopback."""
    context = browser.new_context(viewport=WIDE)
    opened = context.new_page()
    opened.set_default_timeout(1e3 * WAIT_S)
    asked: list[str] = []

    def note(request: Request) -> None:
        asked.append(request.url)

    opened.on("request", note)
    opened.goto(f"{served.url}/?key={KEY}")
    opened.get_by_test_id("state").wait_for()
    # Before it, a click is heard by nobody.
    opened.wait_for_function("window.did_handshake")
    yield opened
    context.close()
    assert asked
    strangers = [
        url
        for url in asked
        if urlsplit(url).scheme not in {"data", "blob"} and urlsplit(url).hostname not in LOOPBACK
    ]
    assert strangers == []
