"""Long work that is cancelled on the page: how soon it answers, and that what was known stays.

Of a model: finding what is missing, and comparing. Of the rig: the analysis of a first shot, on a
host whose machine code is compiled, and on one where it is not. Of a campaign: its report.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from itertools import cycle
from pathlib import Path
from urllib.parse import quote

from playwright.sync_api import Browser

import rigctl
from benchmarks.page_served import LONG_S, RIGCTL, Served, opened, served
from benchmarks.page_waits import CANCELLED, Waited, cancelled

ONCE = 1
"""Compiling is cancelled once: begun again, it goes on where it was."""


def cancels(browser: Browser, daemon: Served, large: Path) -> Iterator[tuple[str, list[Waited]]]:
    """Yield the waits of each kind, shortest first.

    Parameters
    ----------
    large
        A campaign's folder, of so many shots that its model takes several seconds.
    """
    yield from _of_a_model(browser, daemon, large)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "store").mkdir()
        subprocess.run([RIGCTL, "import", str(large)], cwd=folder, check=True, capture_output=True)
        with served(folder) as other:
            yield _of_a_report(browser, other, large.name)
    with tempfile.TemporaryDirectory() as name:
        # Machine code lies beside its source: a copy of the source has none.
        package = Path(rigctl.__file__).parents[1]
        without = shutil.ignore_patterns("__pycache__")
        shutil.copytree(package, Path(name) / "source", ignore=without)
        with served(Path(name), {"PYTHONPATH": str(Path(name) / "source")}) as other:
            yield _of_a_shot(browser, other)


def _of_a_model(
    browser: Browser, daemon: Served, large: Path
) -> Iterator[tuple[str, list[Waited]]]:
    page, _ = opened(browser, daemon.url, [])
    address = f"{daemon.url}/model?folder={quote(str(large))}"
    page.goto(address)
    page.get_by_test_id("amount").wait_for(timeout=1e3 * LONG_S)
    explain = page.get_by_test_id("explain")
    waits = cancelled(page, daemon, explain.click, ("explaining", "story-compare"), CANCELLED)
    yield "find it by itself", waits
    names = page.locator("[data-testid^=try-]").evaluate_all(
        "all => all.map((one) => one.dataset.testid.slice(4))"
    )
    effects = cycle(names)

    def compare() -> None:
        page.goto(f"{address}&effects={next(effects)}")

    yield "comparing", cancelled(page, daemon, compare, ("busy", "story-compare"), len(names))


def _of_a_report(browser: Browser, daemon: Served, name: str) -> tuple[str, list[Waited]]:
    page, _ = opened(browser, daemon.url, [])
    page.goto(f"{daemon.url}/campaigns/{name}")
    report = page.get_by_test_id("report")
    return "report", cancelled(page, daemon, report.click, ("reporting", "report"), CANCELLED)


def _of_a_shot(browser: Browser, daemon: Served) -> tuple[str, list[Waited]]:
    page, _ = opened(browser, daemon.url, [])

    def fire() -> None:
        page.get_by_test_id("arm").click()
        page.get_by_test_id("fire").click()

    waits = cancelled(page, daemon, fire, ("analysing", "refusal"), ONCE)
    return "first analysis while it compiles", waits
