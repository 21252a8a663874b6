"""The report in a browser: alone in the world, wide and narrow, light, dark and on paper."""

from __future__ import annotations

from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page

from rigctl.challenge import new
from rigctl.cli.store.report import report as write_report
from tests.browser.test_accessibility import BAD, VIOLATIONS

pytestmark = pytest.mark.long

PHONE, TABLET = {"width": 390, "height": 800}, {"width": 768, "height": 900}
DESK = {"width": 1280, "height": 900}


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("seen")
    new(folder / "nylon", seed=4, strength="full", shots=12)
    write_report(folder / "nylon", out=folder / "report.html", csv=None, config=None)
    return folder / "report.html"


def opened(browser: Browser, report: Path, size: dict[str, int], scheme: str) -> Page:
    page = browser.new_context(viewport=size, color_scheme=scheme).new_page()
    asked: list[str] = []
    said: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda message: said.append(message.text))
    page.goto(report.as_uri())
    assert asked == [report.as_uri()]
    assert said == []
    return page


BEYOND = """() => [...document.querySelectorAll(".key div")]
  .filter((one) => one.scrollWidth > one.clientWidth).map((one) => one.textContent)"""
"""Key numbers that reach out of their tile."""


@pytest.mark.parametrize("size", [PHONE, TABLET, DESK], ids=["phone", "tablet", "desk"])
def test_it_loads_nothing_and_fits_the_window(
    browser: Browser, report: Path, size: dict[str, int]
) -> None:
    page = opened(browser, report, size, "light")
    assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]
    assert page.evaluate(BEYOND) == []
    page.evaluate(Axe().axe_script)
    assert [fault["id"] for fault in page.evaluate(VIOLATIONS, BAD)] == []
    assert page.locator("figure svg").count() == 3
    for figure in page.locator("figure svg").all():
        assert figure.bounding_box()["height"] > 150
    page.context.close()


def test_ink_is_light_on_dark_and_dark_on_paper(browser: Browser, report: Path) -> None:
    page = opened(browser, report, DESK, "dark")
    ink = "getComputedStyle(document.querySelector('figure svg text')).fill"
    ground = "getComputedStyle(document.body).backgroundColor"
    assert min(colour(page.evaluate(ink))) > 200
    assert max(colour(page.evaluate(ground))) < 60
    page.emulate_media(media="print")
    assert max(colour(page.evaluate(ink))) < 60
    assert min(colour(page.evaluate(ground))) > 240
    page.context.close()


def colour(text: str) -> list[int]:
    return [int(part) for part in text.removeprefix("rgb(").removesuffix(")").split(",")]


def test_a_link_saves_the_table_behind_its_figure(browser: Browser, report: Path) -> None:
    page = opened(browser, report, DESK, "light")
    with page.expect_download() as saved:
        page.get_by_text("figure-7-4.csv").click()
    assert saved.value.suggested_filename == "figure-7-4.csv"
    first = Path(saved.value.path()).read_text().splitlines()[0]
    assert first.startswith("shot,v_s_over_v_n,sigma_v_s_over_v_n")
    page.context.close()
