"""The rig on the page: its limits, the stop, and who may look."""

from __future__ import annotations

import re
from collections.abc import Iterator

import httpx
import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import FIRST_USE_MS, KEY, Served, answer, fire, type_in
from tests.browser.test_accessibility import faults


@pytest.fixture(scope="module", autouse=True)
def released(served: Served) -> Iterator[None]:
    """Leave no stop behind for those who use the daemon after these."""
    yield
    bearer = {"Authorization": f"Bearer {KEY}"}
    url = f"{served.url}/api/v1/rig/release"
    httpx.post(url, headers=bearer, json={"reason": "the tests of the stop have ended"})


def test_the_key_opens_the_page_and_leaves_the_address_bar(page: Page, served: Served) -> None:
    assert page.url == f"{served.url}/"
    assert page.context.cookies()[0]["httpOnly"]
    expect(page.get_by_test_id("kind")).to_have_text("simulated rig")


def test_without_the_key_nothing_of_the_page_is_shown(served: Served) -> None:
    shots = httpx.get(f"{served.url}/shots")
    assert (shots.status_code, shots.headers["location"]) == (303, "/")
    assert "REST" in httpx.get(f"{served.url}/").text
    assert httpx.get(f"{served.url}/?key=wrong").status_code == 401


def test_a_value_out_of_range_is_refused_with_the_range(page: Page) -> None:
    type_in(page.get_by_test_id("pressure_a_kpa"), "500")
    expect(page.get_by_text("5 to 120 kPa is allowed")).to_be_visible()
    expect(page.get_by_test_id("arm")).to_be_disabled()


def test_the_next_film_is_drawn_in_the_place_of_the_last(page: Page) -> None:
    film = page.get_by_test_id("film")
    name = page.get_by_text(re.compile(r"^Shot \d+$"))
    fire(page)
    film.wait_for(timeout=FIRST_USE_MS)
    page.get_by_test_id("coefficients").wait_for(timeout=FIRST_USE_MS)
    first = name.inner_text()
    film.evaluate("(element) => { element.dataset.kept = 'yes'; }")
    frames = page.locator(".strip .frame")
    at_contact = page.get_by_test_id("where").inner_text()
    frames.first.press("Enter")
    expect(page.get_by_test_id("where")).not_to_have_text(at_contact)
    expect(frames.first).to_be_focused()
    assert marked(page) == [0]
    fire(page)
    expect(name).not_to_have_text(first, timeout=FIRST_USE_MS)
    expect(page.get_by_test_id("where")).to_contain_text("at contact", timeout=FIRST_USE_MS)
    number = int(name.inner_text().removeprefix("Shot "))
    expect(page.get_by_role("img", name=re.compile(f"^film of shot {number},"))).to_be_attached()
    assert film.get_attribute("data-kept") == "yes"
    # The strip is drawn after the film.
    page.wait_for_function(
        f"() => ({MARKED}).map((place) => "
        "document.querySelectorAll('.strip .frame')[place].innerText).join() === 'contact'"
    )


MARKED = """[...document.querySelectorAll(".strip .frame")].map((one, place) => [one, place])
  .filter(([one]) => getComputedStyle(one).borderTopColor !== "rgba(0, 0, 0, 0)")
  .map(([, place]) => place)"""


def marked(page: Page) -> list[int]:
    """Return the places of the frames of the strip whose border is drawn."""
    found: list[int] = page.evaluate(MARKED)
    return found


def test_the_stop_is_in_reach_by_button_and_key_and_is_left_with_a_reason(page: Page) -> None:
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("fire")).to_be_enabled()
    page.keyboard.press("Control+.")
    expect(page.get_by_test_id("latched")).to_contain_text("stopped by the page's key")
    expect(page.get_by_test_id("state")).to_have_text("estop")
    expect(page.get_by_test_id("arm")).to_be_disabled()
    assert faults(page) == []
    page.get_by_test_id("release").click()
    expect(page.get_by_test_id("release-now")).to_be_disabled()
    type_in(page.get_by_test_id("reason"), "looked at the tubes: empty")
    answer(page, "release-now")
    expect(page.get_by_test_id("state")).to_have_text("idle")
    page.get_by_role("link", name="Model").click()
    page.get_by_test_id("stop").click()
    expect(page.get_by_test_id("latched")).to_contain_text("stopped by the page's button")


def test_nothing_can_be_pressed_before_the_daemon_hears_it(page: Page, served: Served) -> None:
    unheard = page.context.new_page()
    unheard.route_web_socket(re.compile("."), lambda _: None)
    unheard.route(re.compile("transport=polling"), lambda route: route.abort())
    unheard.goto(served.url, wait_until="commit")
    expect(unheard.get_by_test_id("stop")).to_have_css("pointer-events", "none")
    expect(page.get_by_test_id("stop")).to_have_css("pointer-events", "auto")
