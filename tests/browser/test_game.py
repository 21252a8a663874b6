"""A challenge as a game: a level is chosen, a hint is taken, an answer scored."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import Served, type_in, visit
from tests.browser.test_accessibility import faults
from tests.browser.test_model_page import LONG_MS

pytestmark = pytest.mark.long
CLICKED = "ids => ids.forEach(id => document.querySelector(`[data-testid=${id}]`).click())"


def choose(page: Page, field: str, option: str) -> None:
    """Choose an option of a select by the beginning of its words."""
    page.get_by_test_id(field).click()
    page.get_by_role("option", name=re.compile(option)).click()


def test_a_level_is_made_played_with_a_hint_and_scored(page: Page, served: Served) -> None:
    visit(page, f"{served.url}/model")
    # At once, as no person can: neither click may fall on a button that is drawn anew.
    page.evaluate(CLICKED, ["level-4", "shots-24", "level-1"])
    expect(page.get_by_test_id("level-1")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_test_id("level-4")).to_have_attribute("aria-pressed", "false")
    expect(page.get_by_test_id("shots-24")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_test_id("shots-120")).to_have_attribute("aria-pressed", "false")
    expect(page.get_by_test_id("new-challenge")).to_have_text("Start level 1")
    page.get_by_test_id("new-challenge").click()
    page.get_by_test_id("story-compare").wait_for(timeout=LONG_MS)
    expect(page.get_by_test_id("game")).to_have_text("Level 1: One plain effect. 24 shots.")
    type_in(page.get_by_test_id("answer"), "none")
    # The level says that something is hidden.
    expect(page.get_by_role("option", name="Nothing (none)", exact=True)).to_have_count(0)
    type_in(page.get_by_test_id("answer"), "pressure-leak")
    page.get_by_role(
        "option", name="Pressure leaks while waiting (pressure-leak)", exact=True
    ).click()
    page.keyboard.press("Escape")
    # A hint leaves the answer as far as it is given.
    page.get_by_test_id("take-hint").click()
    # The level has said how much is hidden.
    expect(page.get_by_test_id("hint")).to_contain_text("Hint: Look ")
    choose(page, "sure", "90%")
    page.get_by_test_id("commit").click()
    expect(page.get_by_test_id("ask-again")).to_contain_text("90 % sure")
    page.get_by_role("button", name="Commit", exact=True).click()
    page.get_by_test_id("reveal").click()
    expect(page.get_by_test_id("truth")).to_contain_text("Wrong.")
    # Nothing found, a hint for 20, and 25 (1 - 4 * 0.9²) = -56 for being sure and wrong.
    expect(page.get_by_test_id("score")).to_have_text("Level 1, -76 points")
    expect(page.get_by_test_id("score")).to_be_in_viewport()
    assert faults(page) == []
    sides = page.get_by_test_id("side-by-side").locator("section")
    expect(sides.nth(0)).to_contain_text("What was hidden")
    expect(sides.nth(1)).to_contain_text("Pressure leaks while waiting")
    visit(page, f"{served.url}/model")
    expect(page.get_by_test_id("challenges")).to_contain_text("level 1, 24 shots: −76 points")
