"""A daemon of its own on a free port, and Chromium in front of it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, Page, Request, sync_playwright

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
SWITCHES = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
KEY = "a-key-for-the-page"
WAIT_S = 60.0
WIDE = {"width": 1280, "height": 800}
LOOPBACK = {"127.0.0.1", None}


@dataclass(frozen=True)
class Served:
    """A running daemon: its address, and the folder that it runs in."""

    url: str
    folder: Path


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder = tmp_path_factory.mktemp("daemon")
    process = subprocess.Popen(
        [str(Path(sys.executable).with_name("rigctl")), "serve", "--port", "0"],
        cwd=folder,
        env={**os.environ, "RIGCTL_KEY": KEY},
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        printed = process.stdout.readline()
        assert "?key=" in printed
        yield Served(printed.split(" at ")[1].partition("/?key=")[0].strip(), folder)
    finally:
        process.terminate()
        process.communicate(timeout=WAIT_S)


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
    opened.set_default_timeout(30_000)
    asked: list[str] = []

    def note(request: Request) -> None:
        asked.append(request.url)

    opened.on("request", note)
    opened.goto(f"{served.url}/?key={KEY}")
    opened.get_by_test_id("state").wait_for()
    yield opened
    context.close()
    assert asked
    strangers = [
        url
        for url in asked
        if urlsplit(url).scheme not in {"data", "blob"} and urlsplit(url).hostname not in LOOPBACK
    ]
    assert strangers == []
