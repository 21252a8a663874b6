"""The page without a mouse: Tab, Enter, Space and arrows, with a focus that is seen."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import FIRST_USE_MS, Served
from tests.browser.keyboard import Keyboard
from tests.browser.test_model_page import LONG_MS
from tests.browser.test_own_data import table


def test_own_data_are_brought_and_compared_by_keys_alone(page: Page, served: Served) -> None:
    keys = Keyboard(page)
    keys.open_place("Campaigns")
    keys.press("own")
    page.wait_for_url(re.compile(r"/own$"))
    page.wait_for_function("window.did_handshake")
    # The browser hears that a dialog is awaited on another way than keys, which overtake it; it has
    # heard it once it answers where the focus is.
    with page.expect_file_chooser() as chosen:
        keys.press("drop", "Space")
    chosen.value.set_files(table(served.folder / "by-keys.csv"))
    expect(page.get_by_test_id("own-rows")).to_have_text("39 of 40 rows are impacts.")
    # A meaning is chosen by arrows: the one above the rebound is the fall, which stands already.
    keys.press("means-1")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")
    expect(page.get_by_test_id("own-open")).to_contain_text(
        "“height of the fall” is chosen for two"
    )
    keys.press("means-1")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    expect(page.get_by_test_id("own-rows")).to_have_text("39 of 40 rows are impacts.")
    keys.press("own-compare")
    expect(page.get_by_test_id("story-compare")).to_contain_text(
        "taken from the scatter", timeout=FIRST_USE_MS
    )


@pytest.mark.long
def test_a_challenge_is_played_from_its_level_to_the_broken_seal_by_keys_alone(
    page: Page,
) -> None:
    keys = Keyboard(page)
    keys.open_place("Model")
    keys.press("level-1", "Space")
    keys.press("shots-60", "Space")
    keys.press("new-challenge")
    page.get_by_test_id("amount").wait_for(timeout=LONG_MS)
    story_is_read_by_keys(page, keys)
    keys.press(re.compile("^add-"))
    expect(page.get_by_test_id("story-added")).to_contain_text("the error", timeout=LONG_MS)
    keys.press("take-hint")
    expect(page.get_by_test_id("hint")).to_contain_text("Hint: Look ")
    keys.go_to_named("answer")
    # What was added stands in it already.
    expect(page.get_by_test_id("challenge").locator(".q-chip")).to_have_count(1)
    keys.press("sure")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    keys.press("commit")
    # Whoever presses Enter without reading commits to nothing.
    asked = page.get_by_test_id("ask-again")
    expect(asked.get_by_role("button", name="Cancel")).to_be_focused()
    keys.press("commit-now")
    keys.press("reveal")
    expect(page.get_by_test_id("truth")).to_contain_text("The truth is: “")


def story_is_read_by_keys(page: Page, keys: Keyboard) -> None:
    """Go to a step, through the map, to the film and to the slider; each answers."""
    page.keyboard.press("2")
    expect(page.locator("#step-2")).to_be_focused()
    assert (
        page.locator("#step-2").evaluate("part => getComputedStyle(part).outlineStyle") == "solid"
    )
    where = page.get_by_test_id("story-where")
    told = where.inner_text()
    keys.go_to(page.get_by_test_id("map").locator("[aria-pressed=true]"))
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    expect(where).not_to_have_text(told)
    keys.go_to_named("amount")
    page.keyboard.press("ArrowUp")
    expect(page.get_by_test_id("lead")).not_to_contain_text("Move it: the line")
    page.keyboard.press("1")
    keys.go_to_named("ghost-frame")
    page.keyboard.press("Home")
    expect(page.get_by_test_id("ghost-text")).to_contain_text("ms before contact")


@pytest.mark.long
def test_a_shot_is_fired_and_a_sweep_started_paused_and_given_up_by_keys_alone(page: Page) -> None:
    keys = Keyboard(page)
    keys.type_into("offset_mm", "7")
    keys.press("arm")
    expect(page.get_by_test_id("fire")).to_be_enabled()
    keys.press("fire", "Space")
    expect(page.get_by_test_id("state")).to_have_text("idle", timeout=LONG_MS)
    keys.open_place("Sweeps")
    page.get_by_test_id("preview").wait_for()
    keys.type_into("repeat", "2")
    expect(page.get_by_test_id("sweep-text")).to_have_text("48 shots")
    keys.press("start-sweep")
    page.wait_for_url(re.compile(r"/sweeps/\d{8}-s\d{4}$"))
    page.wait_for_function("window.did_handshake")
    state = page.get_by_test_id("sweep-state")
    keys.press("pause")
    expect(state).to_contain_text("paused", timeout=LONG_MS)
    keys.press("abort")
    keys.press("abort-now")
    expect(state).to_contain_text("aborted", timeout=LONG_MS)
