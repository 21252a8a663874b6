"""The first visit: the rig drawn, a shot fired and read, thirty more offered; the guide hidden."""

from __future__ import annotations

import re
from collections.abc import Iterator
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import FIRST_USE_MS, Served, type_in, visit


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """Serve a store without a shot."""
    running = Served.start(tmp_path_factory.mktemp("empty"))
    yield running
    running.end()


def test_a_newcomer_is_led_from_an_empty_store_to_thirty_shots(page: Page, served: Served) -> None:
    says = page.get_by_test_id("guide-text")
    expect(says).to_contain_text("press Arm, then Fire")
    expect(page.get_by_text("No shot has been fired yet")).to_be_visible()
    drawing = page.get_by_test_id("rig-drawing").locator(".wide-drawing .angle")
    type_in(page.get_by_test_id("offset_mm"), "12.7")
    # Half of a diameter of 25.4 mm: the line of centres is turned by asin(1/2).
    expect(drawing).to_have_text("12.7 mm: 30° off head-on")
    # The slider beside it writes into the number: asin(10 / 25.4) is 23.2 degrees.
    type_in(page.get_by_test_id("offset_mm-slider"), "10")
    expect(drawing).to_have_text("10 mm: 23° off head-on")
    type_in(page.get_by_test_id("offset_mm"), "6")
    expect(page.get_by_test_id("offset_mm-slider")).to_have_value("6")
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("arming")).to_have_text(re.compile("Armed for 40 and 40 kPa"))
    expect(page.get_by_test_id("interlocks")).to_contain_text("pressure a")
    page.get_by_test_id("fire").click()
    expect(says).to_contain_text("the bounce e is 0.7", timeout=FIRST_USE_MS)
    met, parted, e = map(float, re.findall(r"\d+\.\d+", says.inner_text()))
    assert abs(parted / met - e) < 0.01
    coefficients = page.get_by_test_id("coefficients")
    restitution = coefficients.get_by_role("row").filter(has_text=re.compile("^bounce e"))
    value = float(restitution.get_by_role("cell").nth(1).inner_text().partition(" ")[0])
    assert abs(value - 0.74) < 0.01
    expect(page.get_by_test_id("film")).to_be_visible()
    expect(page.get_by_test_id("events")).to_contain_text("shot 1 analysed")
    page.get_by_test_id("guide-next").click()
    expect(page.get_by_test_id("sweep-text")).to_have_text("30 shots")
    expect(page.get_by_test_id("campaign")).to_have_value("first")
    expect(page.get_by_test_id("start-sweep")).to_be_enabled()


def test_a_guide_that_is_hidden_stays_hidden_until_it_is_asked_for(
    page: Page, served: Served
) -> None:
    guide, welcome = page.get_by_test_id("guide"), page.get_by_test_id("welcome")
    expect(guide).to_be_visible()
    page.evaluate("window.drawnOnce = true")
    page.get_by_test_id("hide-guide").click()
    expect(guide).to_have_count(0)
    expect(welcome).to_have_count(0)
    page.get_by_test_id("show-guide").click()
    expect(guide).to_be_visible()
    expect(welcome).to_be_visible()
    keys = page.locator("#keys")
    expect(keys).to_be_hidden()
    page.get_by_test_id("show-guide").click()
    expect(keys).to_be_visible()
    keys.get_by_role("button", name="Close").click()
    page.get_by_test_id("hide-guide").click()
    expect(guide).to_have_count(0)
    assert page.evaluate("window.drawnOnce")
    for place in ("/", "/sweeps"):
        visit(page, served.url + place)
        expect(guide).to_have_count(0)
        expect(page.get_by_test_id("welcome")).to_have_count(0)
    page.get_by_test_id("show-guide").click()
    expect(guide).to_be_visible()
    assert urlsplit(page.url).path == "/sweeps"
