"""The recorder's keypad on the page: a session is recorded, searched, looked at and erased."""

from __future__ import annotations

import re

from playwright.sync_api import Page, expect

from tests.browser.conftest import type_in


def test_a_session_is_recorded_searched_shown_and_erased_when_asked(page: Page) -> None:
    page.get_by_test_id("recorder").click()
    state = page.get_by_test_id("recorder-state")
    # Other modules have fired shots.
    erase(page)
    expect(state).to_contain_text("STOP: session 0 with 0 pictures")
    page.get_by_test_id("key-live").click()
    expect(state).to_contain_text("LIVE")
    page.get_by_test_id("key-record").click()
    expect(state).to_contain_text(re.compile(r"RECORD: session 1 with [1-9]\d+ pictures"))
    page.get_by_test_id("key-stop-tape").click()
    expect(state).to_contain_text("STOP")
    type_in(page.get_by_test_id("search-place"), "12")
    page.get_by_test_id("key-search").click()
    expect(state).to_contain_text("on picture 12 (0.0120 s)")
    expect(page.get_by_test_id("still").locator("img")).to_have_js_property("naturalWidth", 240)
    type_in(page.get_by_test_id("search-place"), "12.5")
    page.get_by_test_id("key-search").click()
    expect(page.get_by_text("is no whole number")).to_be_visible()
    expect(state).to_contain_text("on picture 12")
    page.get_by_test_id("search-kind").click()
    page.get_by_role("option", name="time, s").click()
    type_in(page.get_by_test_id("search-place"), "0.013")
    page.get_by_test_id("key-search").click()
    expect(state).to_contain_text("on picture 13 (0.0130 s)")
    type_in(page.get_by_test_id("gamma"), "0")
    page.get_by_test_id("key-gamma").click()
    expect(page.get_by_text("has no such gamma")).to_be_visible()
    page.get_by_test_id("search-kind").click()
    page.get_by_role("option", name="frame").click()
    type_in(page.get_by_test_id("search-place"), "12")
    page.get_by_test_id("key-search").click()
    expect(state).to_contain_text("on picture 12")
    page.get_by_test_id("key-step-back").click()
    expect(state).to_contain_text("on picture 11")
    page.get_by_test_id("jog-30").click()
    expect(state).to_contain_text("STOP: session 1")
    expect(state).to_contain_text("on picture 0")
    erase(page)


def erase(page: Page) -> None:
    """Erase the tape."""
    page.get_by_test_id("key-erase").click()
    page.get_by_test_id("erase-now").click()
    expect(page.get_by_test_id("tape")).to_contain_text("Tape BOT, 0 sessions")
