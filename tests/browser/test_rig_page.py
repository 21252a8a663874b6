"""The rig on the page: the first shot, the stop, and who may look."""

from __future__ import annotations

import re
from typing import Any

import httpx
from playwright.sync_api import Page, expect

LONG_MS = 60_000
FIRST_USE_MS = 200_000
"""Functions are compiled in the first analysis on a machine, other tests beside it."""


def test_the_key_opens_the_page_and_leaves_the_address_bar(page: Page, served: Any) -> None:
    assert page.url == f"{served.url}/"
    assert page.context.cookies()[0]["httpOnly"]
    expect(page.get_by_test_id("kind")).to_have_text("simulated rig")


def test_without_the_key_nothing_of_the_page_is_shown(served: Any) -> None:
    shots = httpx.get(f"{served.url}/shots")
    assert (shots.status_code, shots.headers["location"]) == (303, "/")
    assert "REST" in httpx.get(f"{served.url}/").text
    assert httpx.get(f"{served.url}/?key=wrong").status_code == 401


def test_a_value_out_of_range_is_refused_with_the_range(page: Page) -> None:
    page.get_by_test_id("pressure_a_kpa").fill("500")
    expect(page.get_by_text("5 to 120 kPa is allowed")).to_be_visible()
    expect(page.get_by_test_id("arm")).to_be_disabled()


def test_from_the_first_start_to_the_first_measured_shot(page: Page) -> None:
    expect(page.get_by_text("No shot has been fired yet")).to_be_visible()
    page.get_by_test_id("campaign").fill("first")
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("arming")).to_have_text(re.compile("Armed for 40 and 40 kPa"))
    expect(page.get_by_test_id("interlocks")).to_contain_text("pressure a")
    page.get_by_test_id("fire").click()
    coefficients = page.get_by_test_id("coefficients")
    coefficients.wait_for(timeout=FIRST_USE_MS)
    restitution = coefficients.get_by_role("row").filter(has_text=re.compile("^bounce e"))
    value = float(restitution.get_by_role("cell").nth(1).inner_text().partition(" ")[0])
    assert abs(value - 0.74) < 0.01
    expect(page.get_by_test_id("film")).to_be_visible()
    expect(page.get_by_test_id("events")).to_contain_text("shot 1 analysed")


def test_the_stop_is_in_reach_by_button_and_key_and_is_left_with_a_reason(page: Page) -> None:
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("fire")).to_be_enabled()
    page.keyboard.press("Control+.")
    expect(page.get_by_test_id("latched")).to_contain_text("stopped by the page's key")
    expect(page.get_by_test_id("state")).to_have_text("estop")
    expect(page.get_by_test_id("arm")).to_be_disabled()
    page.get_by_test_id("release").click()
    expect(page.get_by_test_id("release-now")).to_be_disabled()
    page.get_by_test_id("reason").fill("looked at the tubes: empty")
    page.get_by_test_id("release-now").click()
    expect(page.get_by_test_id("state")).to_have_text("idle")
    page.get_by_role("link", name="Model").click()
    page.get_by_test_id("stop").click()
    expect(page.get_by_test_id("latched")).to_contain_text("stopped by the page's button")


def test_nothing_can_be_pressed_before_the_daemon_hears_it(page: Page, served: Any) -> None:
    unheard = page.context.new_page()
    unheard.route_web_socket(re.compile("."), lambda _: None)
    unheard.route(re.compile("transport=polling"), lambda route: route.abort())
    unheard.goto(served.url, wait_until="commit")
    expect(unheard.get_by_test_id("stop")).to_have_css("pointer-events", "none")
    expect(page.get_by_test_id("stop")).to_have_css("pointer-events", "auto")
