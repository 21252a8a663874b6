"""A shot that cannot be measured, and what the page says of it."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import type_in
from tests.browser.test_accessibility import faults

pytestmark = pytest.mark.long

LONG_MS = 60_000


def test_a_shot_without_a_contact_is_refused_in_words_beside_its_film(page: Page) -> None:
    type_in(page.get_by_test_id("offset_mm"), "24")
    type_in(page.get_by_test_id("delay_us"), "-20000")
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("arming")).to_contain_text("b after −20000 µs")
    page.get_by_test_id("fire").click()
    refusal = page.get_by_test_id("refusal")
    refusal.wait_for(timeout=LONG_MS)
    expect(refusal).to_contain_text("was not measured")
    expect(refusal).to_contain_text("b started 20 ms before a")
    expect(refusal).to_contain_text("Refused at the step")
    expect(refusal.get_by_role("img")).to_have_attribute("aria-label", re.compile("outline"))
    assert faults(page) == []
    page.get_by_role("link", name="open").click()
    expect(page.get_by_test_id("refusal")).to_contain_text("was not measured")
    expect(page.get_by_test_id("where")).to_have_text(re.compile(r"frame \d+ of 0–\d+"))
    assert faults(page) == []
    page.get_by_test_id("do-this").click()
    expect(page.get_by_test_id("delay_us")).to_have_value("0")
    expect(page.get_by_test_id("offset_mm")).to_have_value("24")
    expect(page.get_by_test_id("arm")).to_be_enabled()
