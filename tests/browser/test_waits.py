"""Waits on the page: the step, seconds gone and left, and a way out that keeps what is known."""

from __future__ import annotations

import re
from urllib.parse import quote

from playwright.sync_api import Page, expect

from tests.browser.conftest import Served, visit
from tests.browser.test_model_page import LONG_MS, SEED, challenge


def test_a_long_wait_says_how_far_it_is_and_is_cancelled(page: Page, served: Served) -> None:
    # Enough shots that the search lasts for many seconds on a fast machine too.
    folder = challenge(served.folder / "long", SEED, shots=150)
    visit(page, f"{served.url}/model?folder={quote(str(folder))}")
    page.get_by_test_id("amount").wait_for(timeout=LONG_MS)
    told = page.get_by_test_id("story-compare").inner_text()
    page.get_by_test_id("explain").click()
    wait = page.get_by_test_id("explaining")
    expect(wait).to_contain_text("Finding what is missing", timeout=LONG_MS)
    expect(wait).to_contain_text(re.compile(r"\d+ s gone, (about \d+ s left|longer than usual)"))
    wait.get_by_test_id("cancel-job").click()
    expect(page.get_by_test_id("verdict")).to_contain_text(re.compile(r"Cancelled after \d+ s"))
    expect(wait).to_be_hidden()
    expect(page.get_by_test_id("story-compare")).to_have_text(told)
    expect(page.get_by_test_id("explain")).to_be_enabled()
